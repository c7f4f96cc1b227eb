# Player of archives of takes (.takes) for Godot 3 and 4, one script for both.
#
#   var file = File.new()                                          # Godot 3
#   file.open("res://crab.takes", File.READ)
#   player.open(file.get_buffer(file.get_len()))
#   player.open(FileAccess.get_file_as_bytes("res://crab.takes"))  # Godot 4
#
#   player.play("english/intro_001", 0.1)
#   player.advance(delta)               # once in each frame; then use player.weights
#   player.apply(mesh_instance)         # shapes of the poses' names
#
# Times are seconds on the timeline of a line, whose sound starts at `delay`. Arrays keep their
# length. `open` and `play` return an empty text, or say what is wrong. A damaged curve holds where
# its keys run out.
extends Node

const MAGIC = 0x53454B41544C4C  # LLTAKES and a zero, as a number
const VERSION = 1
const HEADER = 64
const SLOT = 16
const HEAD = 20
const TRACK = 16
const STEPS = 1023
const CRC_AT = 48
const BLOCK = 0xFFFF
const GZIP = 3
const GZIP_HEAD = [0x1F, 0x8B, 8, 0, 0, 0, 0, 0, 0, 0xFF]
const GZIP_END = [1, 0, 0, 0xFF, 0xFF]  # the last block, without bytes
const DAMAGED = "it is damaged; copy it again"

var poses = []
var weights = []
var time = 0.0
var start = 0.0
var delay = 0.0
var end = 0.0
var playing = false

var _data = StreamPeerBuffer.new()
var _size = 0
var _slots = 0
var _index = 0
var _rate = 0.0
var _frames = 0
var _stop = 0
var _tracks = 0
var _from = []
var _fade = 0.0
var _left = 0.0
var _cursors = []


class Cursor:
	var pose = 0
	var keys = 0
	var count = 0
	var at = 0
	var left = 0
	var first = 0
	var last = 0
	var begin = 0.0
	var finish = 0.0
	var low = 0.0
	var scale = 0.0


func open(bytes):
	_data.data_array = bytes
	_size = _data.get_size()
	if _size < HEADER:
		return "it ends early; copy it again"
	if _u64(0) != MAGIC:
		return "it is not an archive of takes"
	if _u16(8) != VERSION:
		return "it has version %d, and this player reads %d" % [_u16(8), VERSION]
	if _u16(10) != 0:
		return "it is a patch, not an archive"
	_slots = _u32(16)
	_index = _u64(24)
	if _u64(40) != _size:
		return "it has %d bytes of %d; copy it again" % [_size, _u64(40)]
	var takes = _u64(32)
	if _index < HEADER or _index > takes or takes > _size or takes - _index != _slots * SLOT:
		return DAMAGED
	if _slots == 0 or _slots & (_slots - 1) or not _has_sum([0, CRC_AT, CRC_AT + 4, takes], CRC_AT):
		return DAMAGED
	var at = HEADER
	poses = []
	weights = []
	_from = []
	_cursors = []
	for _number in range(_u32(20)):
		if at + 2 > _index or at + 2 + _u16(at) > _index:
			return DAMAGED
		var length = _u16(at)
		poses.append(_data.get_utf8_string(length))
		at += 2 + length
		weights.append(0.0)
		_from.append(0.0)
		_cursors.append(Cursor.new())
	return ""


# True if the checksum of all takes is right; it reads the whole file.
func is_whole():
	return _has_sum([_index + _slots * SLOT, _size], CRC_AT + 4)


# The position of a take such as english/intro_001, or 0 if there is none; `_stop` is its end.
func find(name):
	var text = StreamPeerBuffer.new()
	text.put_utf8_string(name)
	var length = text.get_size() - 4
	var value = 0x811C9DC5
	text.seek(4)
	for _number in range(length):
		value = ((value ^ text.get_u8()) * 0x01000193) & 0xFFFFFFFF
	for probe in range(_slots):
		var slot = _index + ((value + probe) & (_slots - 1)) * SLOT
		var at = _u64(slot)
		if at == 0:
			return 0
		var size = _u32(slot + 12)
		if _u32(slot + 8) != value or at < 0 or at > _size - size or size < 4 + length:
			continue
		if _u16(at) != length:
			continue
		_data.seek(at + 4)
		if _data.get_utf8_string(length) == name:
			var body = at + 4 + length + (4 - length % 4) % 4
			if not _is_sound(body, at + size):
				return 0
			_stop = at + size
			return body
	return 0


func play(name, fade = 0.0, at = null):
	var body = find(name)
	if body == 0:
		return "the archive has no sound take '%s'" % name
	_hold(fade)
	_data.seek(body)
	_rate = _data.get_float()
	start = _data.get_float()
	delay = _data.get_float()
	_frames = _data.get_u32()
	_tracks = _data.get_u16()
	end = start + (_frames - 1) / _rate
	playing = true
	for number in range(_tracks):
		var one = _cursors[number]
		_data.seek(body + HEAD + number * TRACK)
		one.pose = _data.get_u16()
		one.count = _data.get_u16()
		one.keys = body + _data.get_u32()
		one.low = _data.get_float()
		one.scale = _data.get_float() / STEPS
		_rewind(one)
	time = min(0.0, start) if at == null else at
	_show()
	return ""


# Plays the same line in another language, from the same share of its length.
func switch(name, fade = 0.0):
	var share = (time - start) / max(end - start, 1e-6)
	var why = play(name, fade)
	if why == "":
		time = start + share * (end - start)
		_show()
	return why


func advance(seconds):
	time += seconds
	_left = max(0.0, _left - seconds)
	_show()


# Goes to a time on the line's timeline; a fade ends.
func seek(to):
	time = to
	_left = 0.0
	_show()


# Ends the line: fades to rest.
func skip(fade = 0.0):
	_hold(fade)
	playing = false
	_tracks = 0
	_show()


# Seconds of the sound now; it has not started below 0.
func sound_time():
	return time - delay


# Combines speech with the game's own weights into `out`: "max", "add", or "replace", which takes
# speech where `region` is 1 and the game's own where it is 0.
func blend(own, mode, region, out):
	for pose in range(weights.size()):
		var speech = weights[pose]
		if mode == "max":
			out[pose] = max(own[pose], speech)
		elif mode == "add":
			out[pose] = min(own[pose] + speech, 1.0)
		else:
			out[pose] = own[pose] + (speech - own[pose]) * region[pose]


func apply(mesh, values = null):
	var shown = weights if values == null else values
	for pose in range(poses.size()):
		mesh.set("blend_shapes/" + poses[pose], shown[pose])


func _hold(fade):
	for pose in range(weights.size()):
		_from[pose] = weights[pose]
	_fade = max(0.0, fade)
	_left = _fade


func _show():
	for pose in range(weights.size()):
		weights[pose] = 0.0
	var frame = min(max((time - start) * _rate, 0.0), max(_frames - 1.0, 0.0))
	for number in range(_tracks):
		var one = _cursors[number]
		if frame < one.first:
			_rewind(one)
		while frame > one.last and one.left > 0:
			_next(one)
		var share = 1.0
		if one.last > one.first:
			share = (frame - one.first) / (one.last - one.first)
		weights[one.pose] = one.begin + (one.finish - one.begin) * share
	if time >= end:
		playing = false
	if _left > 0:
		var share = _left / _fade
		for pose in range(weights.size()):
			weights[pose] += (_from[pose] - weights[pose]) * share


func _rewind(one):
	one.at = one.keys + 2
	one.left = one.count - 1
	one.first = 0
	one.last = 0
	one.finish = one.low + (_u16(one.keys) & STEPS) * one.scale
	one.begin = one.finish


func _next(one):
	var at = one.at
	var word = _u16(at) if at + 2 <= _stop else 0
	var step = word >> 10
	if step == 0:
		at += 2
		if at + 2 > _stop:
			one.left = 0
			return
		step = _u16(at)
	one.at = at + 2
	one.left -= 1
	one.first = one.last
	one.begin = one.finish
	one.last += step
	one.finish = one.low + (word & STEPS) * one.scale


# True if the head of a take and its tracks are sound; keys are checked as they play.
func _is_sound(body, last):
	if body + HEAD > last:
		return false
	_data.seek(body)
	var rate = _data.get_float()
	var begins = _data.get_float()
	var sounds = _data.get_float()
	var frames = _data.get_u32()
	var tracks = _u16(body + 16)
	if not (rate > 0 and rate < 1e6 and abs(begins) < 1e6 and abs(sounds) < 1e6):
		return false
	if frames == 0 or tracks > poses.size():
		return false
	if body + HEAD + tracks * TRACK > last:
		return false
	for number in range(tracks):
		var track = body + HEAD + number * TRACK
		if _u16(track) >= poses.size() or _u16(track + 2) == 0:
			return false
		if body + _u32(track + 4) + 2 > last:
			return false
		var low = _data.get_float()
		var span = _data.get_float()
		if not (abs(low) < 1e9 and abs(span) < 1e9):
			return false
	return true


# True if the CRC-32 of spans of the file is the one at a position. A script is slow at it and Godot
# shows no function for it, so the spans become a GZIP of stored blocks, which Godot checks.
func _has_sum(spans, at):
	var packed = StreamPeerBuffer.new()
	for byte in GZIP_HEAD:
		packed.put_u8(byte)
	var size = 0
	for number in range(0, spans.size(), 2):
		for first in range(spans[number], spans[number + 1], BLOCK):
			var length = min(BLOCK, spans[number + 1] - first)
			packed.put_u8(0)
			packed.put_u16(length)
			packed.put_u16(BLOCK - length)
			_data.seek(first)
			packed.put_data(_data.get_data(length)[1])
			size += length
	for byte in GZIP_END:
		packed.put_u8(byte)
	packed.put_u32(_u32(at))
	packed.put_u32(size)
	return packed.data_array.decompress(size, GZIP).size() == size


func _u16(at):
	_data.seek(at)
	return _data.get_u16()


func _u32(at):
	_data.seek(at)
	return _data.get_u32()


func _u64(at):
	_data.seek(at)
	return _data.get_u64()
