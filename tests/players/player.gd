# Runs steps of a file on an archive in Godot 3, and prints the weights after each.
extends SceneTree


func _initialize():
	var player = load("res://takes.gd").new()
	var file = File.new()
	file.open("res://a.takes", File.READ)
	var why = player.open(file.get_buffer(file.get_len()))
	if why != "":
		print("WRONG ", why)
		quit(2)
		return
	var own = []
	var region = []
	var out = []
	for pose in range(player.poses.size()):
		own.append(0.3)
		region.append(pose % 2)
		out.append(0.0)
	file.open("res://steps.txt", File.READ)
	for line in file.get_as_text().strip_edges().split("\n"):
		var parts = line.split(" ")
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
		for value in shown:
			said.append("%.6f" % value)
		said.append("%.6f" % player.sound_time())
		print("SAID ", PoolStringArray(said).join(" "))
	player.free()
	quit()
