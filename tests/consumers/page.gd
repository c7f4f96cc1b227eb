# Play the script of docs/how-to/godot.md in Godot 3, and say what the face shows while it sounds.
#
#   godot3-server --path PROJECT --script page.gd
#
# The project has hello.glb, hello.wav and speaking.gd. What is said is JSON on one line: of each frame
# the time of the animation, of the sound (-1 before and after it), and each blend shape.
extends SceneTree

const SHAPES = "blend_shapes/"

var face
var player
var mesh
var frames = []
var waited = 0.0


func _initialize():
	face = load("res://hello.glb").instance()
	var sound = AudioStreamPlayer.new()
	sound.name = "Sound"
	face.add_child(sound)
	face.set_script(load("res://speaking.gd"))
	root.add_child(face)
	player = face.get_node("AnimationPlayer")
	mesh = meshes(face)[0]


func meshes(node):
	var found = [node] if node is MeshInstance else []
	for child in node.get_children():
		found += meshes(child)
	return found


func _idle(delta):
	if waited == 0.0:
		face.speak(player.get_animation_list()[-1], load("res://hello.wav"))
	waited += delta
	if waited > delta:
		frames.append(shown())
	if waited > 30.0 or (waited > delta and face.time < 0.0):
		print("SAID ", JSON.print(frames))
		quit()


func shown():
	var sound = face.get_node("Sound")
	var weights = {}
	for property in mesh.get_property_list():
		if property.name.begins_with(SHAPES):
			weights[property.name.substr(len(SHAPES))] = mesh.get(property.name)
	return {
		"at": player.current_animation_position,
		"heard": sound.get_playback_position() if sound.playing else -1,
		"weights": weights,
	}
