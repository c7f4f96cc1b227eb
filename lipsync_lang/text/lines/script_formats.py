"""Formats of scripts in JSON and XML that differ in their paths and names alone."""

from lipsync_lang.text.lines.json_scripts import JsonScript, add_json_script
from lipsync_lang.text.lines.xml_scripts import XmlScript, add_xml_script

for _json in (
    JsonScript(
        "json-tree",
        "Trees of texts in JSON, as i18next and others have them: the keys name a line.",
        languages="",
        skipped="@",
    ),
    JsonScript(
        "arb",
        "Flutter's .arb: a text for each name, in ICU's form.",
        (".arb",),
        skipped="@",
    ),
    JsonScript(
        "chrome-messages",
        "Messages of browser extensions: objects with `message` and `description`.",
        text="message",
        note="description",
    ),
    JsonScript(
        "formatjs",
        "Messages of FormatJS: objects with `defaultMessage` and `description`.",
        text="defaultMessage",
        id="id",
        note="description",
    ),
    JsonScript(
        "xcstrings",
        "Xcode's string catalogues: texts of all languages, with their plurals.",
        (".xcstrings",),
        text="stringUnit.value",
        note="comment",
        state="stringUnit.state",
        unready=("new",),
        languages="localizations",
        native="sourceLanguage",
        unnamed=("strings", "localizations", "variations", "plural"),
    ),
    JsonScript(
        "unreal-archive",
        "Unreal's .archive: translations with their source texts and keys.",
        (".archive",),
        text="Translation.Text",
        original="Source.Text",
        id="Key",
        within="Namespace",
    ),
    JsonScript(
        "unreal-manifest",
        "Unreal's .manifest: source texts with their keys.",
        (".manifest",),
        text="Source.Text",
        id="Keys[0].Key",
        within="Namespace",
    ),
):
    add_json_script(_json, __name__)

for _xml in (
    XmlScript(
        "xliff",
        "XLIFF 1.2 and 2: targets of units, or sources where nothing is translated.",
        (".xlf", ".xliff"),
        entries="trans-unit|unit",
        id="@resname|@name|@id",
        each="segment|.",
        text="target",
        original="source",
        note="note|notes/note",
        state="target@state|@state",
        unready=("new", "needs-translation", "needs-l10n", "initial"),
        source_language="source-language|srcLang",
        target_language="target-language|trgLang",
    ),
    XmlScript(
        "android-strings",
        "Android's strings.xml: texts, plurals and arrays.",
        (".xml",),
        entries="string|plurals|string-array",
        id="@name",
        each="item|.",
        text=".",
        root="resources",
        form="@quantity",
        escapes=True,
    ),
    XmlScript(
        "resx",
        ".NET's .resx and .resw: a text for each name.",
        (".resx", ".resw"),
        entries="data",
        id="@name",
        text="value",
        note="comment",
        without=("type", "mimetype"),
    ),
):
    add_xml_script(_xml, __name__)
