"""Two hundred lines of each kind of script, beside a reading by the standard libraries."""

import io
import json
import plistlib
import random
import re
from xml.etree import ElementTree as ET

import pytest
from lanes import needs_plug_ins
from ruamel.yaml import YAML

from lipsync_lang.text.lines import read_lines

COUNT = 200
TOKENS = re.findall(
    r"\S+",
    'maps "old" it\'s & könnyű ¿qué? 地図、 карта مرحبا naïve… — 3,5 C 7:30 #2 Ångström ok! e.g. '
    "no yes null 'tis 1st l’été 会議。 a/b ;x = 'n' y: - ok",
)
"""Words with the characters that formats quote or escape; a backslash begins an escape in some."""


def texts():
    """Return lines of one to nine words, of several rows at times, which begin with a letter."""
    chosen = random.Random(5)  # noqa: S311 a test
    rows = (chosen.choices(TOKENS, k=chosen.randint(1, 9)) for _ in range(COUNT))
    return {
        f"scene{at // 20}.line_{at}": f"Line{at} " + ("\n" if at % 7 == 0 else " ").join(row)
        for at, row in enumerate(rows)
    }


def element(tag, inner=(), text=None, **attributes):
    made = ET.Element(tag, attributes)
    made.text = text
    made.extend(inner)
    return made


def whole(root):
    ET.indent(root)
    return ET.tostring(root, "unicode", xml_declaration=True)


def tree(said):
    """Return texts as a tree by the dots of their names."""
    made = {}
    for name, text in said.items():
        scene, line = name.split(".")
        made.setdefault(scene, {})[line] = text
    return made


def flat(document):
    return {f"{a}.{b}": text for a, inner in document.items() for b, text in inner.items()}


def xliff1(said):
    units = [
        element("trans-unit", [element("source", text=t.upper()), element("target", text=t)], id=n)
        for n, t in said.items()
    ]
    body = element("file", [element("body", units)], **{"source-language": "en"})
    return whole(element("xliff", [body], version="1.2"))


def xliff2(said):
    parts = {n: [element("source", text=t)] for n, t in said.items()}
    units = [element("unit", [element("segment", part)], id=n) for n, part in parts.items()]
    return whole(element("xliff", [element("file", units, id="f")], version="2.0", srcLang="en"))


def read_xliff(text, unit, path):
    return {one.get("id"): one.find(path).text for one in ET.XML(text).iter(unit)}


def android(said):
    quoted = {n: re.sub(r"""(["'\\])""", r"\\\1", t).replace("\n", "\\n") for n, t in said.items()}
    return whole(
        element("resources", [element("string", text=t, name=n) for n, t in quoted.items()])
    )


def read_android(text):
    signs = {"\\n": "\n"}
    return {
        one.get("name"): re.sub(r"\\.", lambda f: signs.get(f[0], f[0][1]), one.text)
        for one in ET.XML(text).iter("string")
    }


def resx(said):
    return whole(
        element(
            "root", [element("data", [element("value", text=t)], name=n) for n, t in said.items()]
        )
    )


def read_resx(text):
    return {one.get("name"): one.findtext("value") for one in ET.XML(text).iter("data")}


def strings(said):
    return "".join(f"{quoted(n)} = {quoted(t)};\n" for n, t in said.items())


def quoted(text):
    return json.dumps(text, ensure_ascii=False)


def read_strings(text):
    return json.loads(
        "{" + re.sub(r'" = "', '": "', text).replace(";\n", ",\n").rstrip(",\n") + "}"
    )


def stringsdict(said):
    rules = {"NSStringFormatSpecTypeKey": "NSStringPluralRuleType"}
    made = {
        n: {"NSStringLocalizedFormatKey": "%#@n@", "n": {**rules, "other": t}}
        for n, t in said.items()
    }
    return plistlib.dumps(made).decode()


def read_stringsdict(text):
    return {f"{n}-other": one["n"]["other"] for n, one in plistlib.loads(text.encode()).items()}


def xcstrings(said):
    made = {
        n: {"localizations": {"en": {"stringUnit": {"state": "translated", "value": t}}}}
        for n, t in said.items()
    }
    return json.dumps({"sourceLanguage": "en", "strings": made, "version": "1.0"}, indent=2)


def read_xcstrings(text):
    found = json.loads(text)["strings"].items()
    return {n: one["localizations"]["en"]["stringUnit"]["value"] for n, one in found}


def rails(said):
    stream = io.StringIO()
    YAML().dump({"en": tree(said)}, stream)
    return stream.getvalue()


def read_rails(text):
    return flat(YAML(typ="safe", pure=True).load(text)["en"])


def archive(said):
    made = [
        {"Source": {"Text": "x"}, "Translation": {"Text": t}, "Key": n} for n, t in said.items()
    ]
    return json.dumps({"FormatVersion": 2, "Namespace": "", "Children": made}, indent=1)


def read_archive(text):
    return {one["Key"]: one["Translation"]["Text"] for one in json.loads(text)["Children"]}


def rpg_maker(said):
    commands = []
    for text in said.values():
        commands.append({"code": 101, "indent": 0, "parameters": ["", 0, 0, 2, "Bo"]})
        commands += [{"code": 401, "indent": 0, "parameters": [row]} for row in text.split("\n")]
    return json.dumps([None, {"id": 1, "list": [*commands, {"code": 0, "parameters": []}]}])


def read_rpg_maker(text):
    found, name = {}, ""
    for at, command in enumerate(json.loads(text)[1]["list"]):
        name = f"script.1.{at}" if command["code"] == 101 else name
        if command["code"] == 401:
            found[name] = f"{found.get(name, '')}\n{command['parameters'][0]}"
    return found


KINDS = {
    "xliff-1": (".xlf", xliff1, lambda text: read_xliff(text, "trans-unit", "target")),
    "xliff-2": (".xlf", xliff2, lambda text: read_xliff(text, "unit", "segment/source")),
    "json": (".json", lambda said: json.dumps(tree(said)), lambda text: flat(json.loads(text))),
    "arb": (".arb", lambda said: json.dumps(said, indent=2), json.loads),
    "android": (".xml", android, read_android),
    "resx": (".resx", resx, read_resx),
    "strings": (".strings", strings, read_strings),
    "stringsdict": (".stringsdict", stringsdict, read_stringsdict),
    "xcstrings": (".xcstrings", xcstrings, read_xcstrings),
    "rails": (".yml", rails, read_rails),
    "unreal": (".archive", archive, read_archive),
    "rpg-maker": (".json", rpg_maker, read_rpg_maker),
}

PLUGGED = {"strings", "stringsdict", "rails", "rpg-maker"}
"""Kinds that plug-ins read."""


def one_row(text):
    return " ".join(text.replace("’", "'").split())


@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=needs_plug_ins if kind in PLUGGED else ()) for kind in KINDS]
)
def test_lines_are_those_of_the_standard_libraries(kind, tmp_path):
    suffix, write, read = KINDS[kind]
    text = write(texts())
    path = tmp_path / f"script{suffix}"
    path.write_text(text, "utf-8")
    expected = {name: one_row(said) for name, said in read(text).items()}
    found = [(line.name, one_row(line.text)) for line in read_lines(path, remark=lambda _: None)]
    assert found == [*expected.items()]
    assert len(found) == COUNT
