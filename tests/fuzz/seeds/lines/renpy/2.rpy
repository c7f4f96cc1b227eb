# comment "not this"
define e = Character("Eileen", color="#fff")
image e happy = "e.png"
label start:
    play music "song.ogg"
    e "Hello, {i}you{/i}! It's [player]. \"Yes\"\nno" # "no"
    e happy @ -wave "Attributes" (what_size=3) with dissolve
    "Bob" "Named."
    'Narrated, don\'t you see?'
    e "Over
       two lines."
    extend " more"
    custom don't care
    $ x = "python"
    python:
        y = "not"

        z = {"a": "b"}
    e """
    First paragraph
    goes on.

    Second.
    """
    menu:
        "What now?"
        "Tea" if tea > 1:
            e "Tea it is."
screen hello():
    text "not"
translate french start_915:
    # e "Hello"
    e "Bonjour"
translate french strings:
    old "Tea"
    new "Thé"
    old "Cup"
    new ""
