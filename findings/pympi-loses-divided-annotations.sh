#!/usr/bin/env bash
# pympi-ling 1.71 (MIT), which reads and writes documents of ELAN, seen on 2026-11-30.
#
# Behaviour: ELAN may divide a word into phones without measuring them. It stores time slots without a value (time
# subdivision) or references to the word (symbolic subdivision), and shows the phones as even parts of the word.
# `Eaf.to_textgrid` leaves out all phones of the first kind. It keeps one phone of the second kind, as long as the word.
# Nothing is said: an interval that does not fit into its tier is dropped.
#
# What a good engineer expects: phones in the places where ELAN shows them, or an error.
# What to do: share the time of the word out before the conversion, and compare the numbers of labels after it.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check pympi-ling==1.71
cat > words.eaf <<'XML'
<?xml version="1.0" encoding="UTF-8"?>
<ANNOTATION_DOCUMENT AUTHOR="" DATE="2026-01-01T00:00:00Z" FORMAT="3.0" VERSION="3.0"
  xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
  xsi:noNamespaceSchemaLocation="http://www.mpi.nl/tools/elan/EAFv3.0.xsd">
  <HEADER MEDIA_FILE="" TIME_UNITS="milliseconds"/>
  <TIME_ORDER>
    <TIME_SLOT TIME_SLOT_ID="ts1" TIME_VALUE="0"/>
    <TIME_SLOT TIME_SLOT_ID="ts2"/>
    <TIME_SLOT TIME_SLOT_ID="ts3"/>
    <TIME_SLOT TIME_SLOT_ID="ts4" TIME_VALUE="300"/>
  </TIME_ORDER>
  <TIER LINGUISTIC_TYPE_REF="plain" TIER_ID="words">
    <ANNOTATION>
      <ALIGNABLE_ANNOTATION ANNOTATION_ID="a1" TIME_SLOT_REF1="ts1" TIME_SLOT_REF2="ts4">
        <ANNOTATION_VALUE>map</ANNOTATION_VALUE>
      </ALIGNABLE_ANNOTATION>
    </ANNOTATION>
  </TIER>
  <TIER LINGUISTIC_TYPE_REF="time" PARENT_REF="words" TIER_ID="by time">
    <ANNOTATION>
      <ALIGNABLE_ANNOTATION ANNOTATION_ID="a2" TIME_SLOT_REF1="ts1" TIME_SLOT_REF2="ts2">
        <ANNOTATION_VALUE>m</ANNOTATION_VALUE>
      </ALIGNABLE_ANNOTATION>
    </ANNOTATION>
    <ANNOTATION>
      <ALIGNABLE_ANNOTATION ANNOTATION_ID="a3" TIME_SLOT_REF1="ts2" TIME_SLOT_REF2="ts3">
        <ANNOTATION_VALUE>æ</ANNOTATION_VALUE>
      </ALIGNABLE_ANNOTATION>
    </ANNOTATION>
    <ANNOTATION>
      <ALIGNABLE_ANNOTATION ANNOTATION_ID="a4" TIME_SLOT_REF1="ts3" TIME_SLOT_REF2="ts4">
        <ANNOTATION_VALUE>p</ANNOTATION_VALUE>
      </ALIGNABLE_ANNOTATION>
    </ANNOTATION>
  </TIER>
  <TIER LINGUISTIC_TYPE_REF="symbolic" PARENT_REF="words" TIER_ID="by reference">
    <ANNOTATION>
      <REF_ANNOTATION ANNOTATION_ID="a5" ANNOTATION_REF="a1">
        <ANNOTATION_VALUE>m</ANNOTATION_VALUE>
      </REF_ANNOTATION>
    </ANNOTATION>
    <ANNOTATION>
      <REF_ANNOTATION ANNOTATION_ID="a6" ANNOTATION_REF="a1" PREVIOUS_ANNOTATION="a5">
        <ANNOTATION_VALUE>æ</ANNOTATION_VALUE>
      </REF_ANNOTATION>
    </ANNOTATION>
    <ANNOTATION>
      <REF_ANNOTATION ANNOTATION_ID="a7" ANNOTATION_REF="a1" PREVIOUS_ANNOTATION="a6">
        <ANNOTATION_VALUE>p</ANNOTATION_VALUE>
      </REF_ANNOTATION>
    </ANNOTATION>
  </TIER>
  <LINGUISTIC_TYPE GRAPHIC_REFERENCES="false" LINGUISTIC_TYPE_ID="plain" TIME_ALIGNABLE="true"/>
  <LINGUISTIC_TYPE CONSTRAINTS="Time_Subdivision" GRAPHIC_REFERENCES="false" LINGUISTIC_TYPE_ID="time" TIME_ALIGNABLE="true"/>
  <LINGUISTIC_TYPE CONSTRAINTS="Symbolic_Subdivision" GRAPHIC_REFERENCES="false" LINGUISTIC_TYPE_ID="symbolic" TIME_ALIGNABLE="false"/>
  <CONSTRAINT DESCRIPTION="parts of a parent's time, without gaps" STEREOTYPE="Time_Subdivision"/>
  <CONSTRAINT DESCRIPTION="parts of a parent, without times" STEREOTYPE="Symbolic_Subdivision"/>
</ANNOTATION_DOCUMENT>
XML
env/bin/python - > seen 2> errors <<'PYTHON' || { cat errors >&2; exit 1; }
from importlib.metadata import version

from pympi import Elan

print("pympi-ling", version("pympi-ling"))
document = Elan.Eaf("words.eaf")
for tier in document.to_textgrid().get_tiers():
    print(f"{tier.name}:", *document.get_annotation_data_for_tier(tier.name))
    print("  as TextGrid:", *tier.get_all_intervals())
PYTHON
cat errors >> seen
diff seen - <<'SEEN'
pympi-ling 1.71
words: (0, 300, 'map')
  as TextGrid: (0.0, 0.3, 'map')
by time: (0, None, 'm') (None, None, 'æ') (None, 300, 'p')
  as TextGrid: (0, 0.3, '')
by reference: (0, 300, 'm', 'map') (0, 300, 'æ', 'map') (0, 300, 'p', 'map')
  as TextGrid: (0.0, 0.3, 'm')
SEEN
echo "as before: a TextGrid by pympi lacks the phones of divided words"
