# Play animations in Godot 3, without a window, and say which values the shapes take.
#
#   ASKED='{"files": ["line.tres", "face.glb"], "times": [0.0, 0.5]}' \
#     godot3-server --path PROJECT --script godot.gd
#
# An Animation moves a mesh that has a shape for each of its tracks, or the SCENE of that name beside
# the files; a scene moves its own. What is said is JSON on one line: of each file its length, and the values of each track at the times.
extends SceneTree

const SHAPES = "blend_shapes/"


func _initialize():
	var asked = JSON.parse(OS.get_environment("ASKED")).result
	var said = {}
	for name in asked.files:
		said[name] = sampled(load("res://" + name), asked.times)
	print("SAID ", JSON.print(said))
	quit()


func sampled(resource, times):
	var scene
	var player
	if resource is Animation:
		var model = OS.get_environment("SCENE")
		scene = load("res://" + model).instance() if model else face(resource)
		player = AnimationPlayer.new()
		scene.add_child(player)
		player.add_animation("line", resource)
	else:
		scene = resource.instance()
		player = first(scene, "AnimationPlayer")
	root.add_child(scene)
	var name = player.get_animation_list()[-1]
	var animation = player.get_animation(name)
	player.play(name)
	var tracks = {}
	for track in animation.get_track_count():
		var path = animation.track_get_path(track)
		var node = player.get_node(player.root_node).get_node(node_of(path))
		var values = []
		for time in times:
			player.seek(time, true)
			values.append(node.get(path.get_concatenated_subnames()))
		tracks[path.get_concatenated_subnames()] = values
	return {"length": animation.length, "step": animation.step, "tracks": tracks}


func node_of(path):
	var names = []
	for number in path.get_name_count():
		names.append(path.get_name(number))
	return PoolStringArray(names).join("/")


func first(node, type):
	if node.is_class(type):
		return node
	for child in node.get_children():
		var found = first(child, type)
		if found:
			return found
	return null


# A triangle with a shape for each track.
func face(animation):
	var arrays = []
	arrays.resize(ArrayMesh.ARRAY_MAX)
	arrays[ArrayMesh.ARRAY_VERTEX] = PoolVector3Array([Vector3(), Vector3.RIGHT, Vector3.UP])
	var mesh = ArrayMesh.new()
	var shapes = []
	for track in animation.get_track_count():
		var property = animation.track_get_path(track).get_concatenated_subnames()
		mesh.add_blend_shape(property.substr(len(SHAPES)))
		shapes.append(arrays)
	mesh.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays, shapes)
	var node = MeshInstance.new()
	node.mesh = mesh
	return node
