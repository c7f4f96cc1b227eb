# Runs the steps of a file in Godot 3, and prints what each shows.
extends SceneTree


func _initialize():
	var player = null
	var own = []
	var region = []
	var out = []
	var file = File.new()
	file.open("res://steps.txt", File.READ)
	for line in file.get_as_text().strip_edges().split("\n"):
		var parts = line.split(" ")
		if parts[0] == "open":
			var archive = File.new()
			archive.open(parts[1], File.READ)
			if player != null:
				player.free()
			player = load("res://takes.gd").new()
			var sound = player.open(archive.get_buffer(archive.get_len())) == ""
			print("SAID ", int(sound))
			own = []
			region = []
			out = []
			for pose in range(player.poses.size()):
				own.append(0.3)
				region.append(pose % 2)
				out.append(0.0)
			if not sound:
				player.free()
				player = null
		elif player != null:
			var shown = player.weights
			match parts[0]:
				"play":
					player.play(parts[1], float(parts[2]))
				"switch":
					player.switch(parts[1], float(parts[2]))
				"blend":
					player.blend(own, parts[1], region, out)
					shown = out
				_:
					player.call(parts[0], float(parts[1]))
			var said = []
			for value in shown + [player.sound_time(), int(player.playing)]:
				said.append("%.6f" % value)
			print("SAID ", PoolStringArray(said).join(" "))
	if player != null:
		player.free()
	quit()
