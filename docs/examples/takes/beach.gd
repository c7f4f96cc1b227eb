# The crab speaks in Godot 3 without a window: it plays ten lines, changes the language of each, and
# skips the last. Prints the widest opening of each line.
#
#   godot3-server --path . --script beach.gd
extends SceneTree

const FRAME = 1.0 / 60
const FADE = 0.15


func _initialize():
	var file = File.new()
	file.open("res://crab.takes", File.READ)
	var player = load("res://takes.gd").new()
	var why = player.open(file.get_buffer(file.get_len()))
	for number in range(1, 11):
		var line = "beach_%02d" % number
		if why == "":
			why = player.play("english/" + line, FADE)
		var widest = 0.0
		for language in ["german", "spanish"]:
			for _frame in range(20):
				player.advance(FRAME)
				widest = max(widest, player.weights.max())
			if why == "":
				why = player.switch(language + "/" + line, FADE)
		print("SAID ", line, " ", widest)
	player.skip(FADE)
	for _frame in range(20):
		player.advance(FRAME)
	print("REST ", player.weights.max())
	if why != "":
		printerr(why)
	player.free()
	quit()
