"""Lip sync in Blender: a panel that lets the selected face speak.

Install this file with Edit > Preferences > Add-ons > Install from Disk, and select the meshes of a
face with shape keys. The panel is in the sidebar of the 3D view (N), under "Lip sync". It calls the
program `lipsync-lang`, which must be installed; the preferences of the add-on hold its path.
"""

import runpy
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import bpy
from bpy.props import BoolProperty, IntProperty, StringProperty

bl_info = {
    "name": "lipsync_lang",
    "description": "Let the selected face speak a text, with or without a recording",
    "author": "The authors of lipsync_lang",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "View3D > Sidebar > Lip sync",
    "category": "Animation",
}

FIRST = 1
"""The frame at which a script of lipsync-lang has time zero."""

LONGEST_SECONDS = 900


def command(program, face, out, told):
    """Return the command that makes the script and the sound of a line, as a list of words.

    `told` has the text, the language, the recording (maybe empty), frames per second, and the frame
    at which the sound begins.
    """
    words = [program, "run", told["text"], "-l", told["language"], "-c", str(face)]
    if told["recording"]:
        words += ["--audio", told["recording"]]
    offset = (told["frame"] - FIRST) / told["fps"]
    words += ["--fps", f"{told['fps']:.6g}", "--offset", f"{offset:.6f}"]
    return [*words, "-o", str(out / "line.py"), "-o", str(out / "line.wav")]


def ended(words):
    """Run a command; return its remarks, or raise RuntimeError with its message."""
    quiet = {"creationflags": subprocess.CREATE_NO_WINDOW} if sys.platform == "win32" else {}
    try:
        done = subprocess.run(
            words, capture_output=True, check=False, timeout=LONGEST_SECONDS, **quiet
        )
    except OSError as error:
        where = "state its path in the preferences of the add-on"
        raise RuntimeError(f"{words[0]} does not start ({error.strerror}); {where}") from None
    except subprocess.TimeoutExpired:
        raise RuntimeError("the line took too long; try a shorter one") from None
    told = done.stderr.decode("utf-8", "replace").strip()
    if done.returncode:
        raise RuntimeError(told or f"{words[0]} ended with code {done.returncode}")
    return told


def exported(path):
    """Save the selected meshes as a model, by which the program knows the shape keys."""
    bpy.ops.export_scene.gltf(
        filepath=str(path), export_format="GLB", use_selection=True, export_animations=False,
        export_materials="NONE", export_morph_normal=False, export_yup=True,
    )  # fmt: skip


def add_sound(scene, path, frame):
    """Put the sound into a free channel of the video sequencer, kept within the scene's file."""
    editor = scene.sequence_editor or scene.sequence_editor_create()
    strips = editor.strips if hasattr(editor, "strips") else editor.sequences  # before 4.4
    taken = {strip.channel for strip in strips}
    channel = next(number for number in range(1, len(taken) + 2) if number not in taken)
    strip = strips.new_sound(path.stem, str(path), channel=channel, frame_start=frame)
    strip.sound.pack()
    scene.sync_mode = "AUDIO_SYNC"
    scene.use_audio_scrub = True


class LipSyncLine(bpy.types.PropertyGroup):
    """The line that is said, and its place."""

    text: StringProperty(name="Text", description="What the face says")
    language: StringProperty(
        name="Language", default="english", description="A name or tag, such as german or pt-BR"
    )
    recording: StringProperty(
        name="Recording", subtype="FILE_PATH", description="The text, spoken by an actor; or none"
    )
    frame: IntProperty(name="Frame", default=FIRST, description="Where the sound begins")
    sound: BoolProperty(name="Add the sound", default=True)


class LipSyncPreferences(bpy.types.AddonPreferences):
    """The path of the program."""

    bl_idname = __name__
    program: StringProperty(
        name="Program", default="lipsync-lang", description="lipsync-lang, or the path of it"
    )

    def draw(self, _context):
        self.layout.prop(self, "program")


class LIPSYNC_OT_speak(bpy.types.Operator):
    """Key the shape keys of the selected meshes so that they speak the text"""

    bl_idname = "lipsync.speak"
    bl_label = "Speak"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return any(one.type == "MESH" and one.data.shape_keys for one in context.selected_objects)

    def execute(self, context):
        scene, line = context.scene, context.scene.lipsync_line
        recording = bpy.path.abspath(line.recording) if line.recording else ""
        if not line.text.strip():
            self.report({"ERROR"}, "Write the text that the face says")
            return {"CANCELLED"}
        told = {
            "text": line.text, "language": line.language, "recording": recording,
            "fps": scene.render.fps / scene.render.fps_base, "frame": line.frame,
        }  # fmt: skip
        added = context.preferences.addons.get(__name__)
        program = added.preferences.program if added else "lipsync-lang"
        with TemporaryDirectory(prefix="lipsync-lang-") as folder:
            face, out = Path(folder, "face.glb"), Path(folder)
            try:
                exported(face)
                remarks = ended(command(program, face, out, told)).replace(str(face), "the face")
                runpy.run_path(str(out / "line.py"))
            except RuntimeError as error:
                self.report({"ERROR"}, str(error))
                return {"CANCELLED"}
            if line.sound:
                add_sound(scene, out / "line.wav", line.frame)
        for remark in remarks.splitlines()[1:]:
            if not remark.startswith("wrote "):
                self.report({"WARNING"}, remark)
        self.report({"INFO"}, f"The face says: {line.text}")
        return {"FINISHED"}


class LIPSYNC_PT_panel(bpy.types.Panel):
    """The panel in the sidebar."""

    bl_label = "Lip sync"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Lip sync"

    def draw(self, context):
        column, line = self.layout.column(), context.scene.lipsync_line
        for name in ("text", "language", "recording", "frame", "sound"):
            column.prop(line, name)
        column.operator("lipsync.speak", icon="PLAY_SOUND")
        if not LIPSYNC_OT_speak.poll(context):
            column.label(text="Select a mesh with shape keys", icon="INFO")


CLASSES = (LipSyncLine, LipSyncPreferences, LIPSYNC_OT_speak, LIPSYNC_PT_panel)


def register():
    """Add the panel."""
    for one in CLASSES:
        bpy.utils.register_class(one)
    bpy.types.Scene.lipsync_line = bpy.props.PointerProperty(type=LipSyncLine)


def unregister():
    """Remove the panel."""
    del bpy.types.Scene.lipsync_line
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)


if __name__ == "__main__":
    register()
