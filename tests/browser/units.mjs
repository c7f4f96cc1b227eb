// Check the pure functions of the page: node units.mjs STATIC. Prints the names of those that fail.
import assert from "node:assert/strict";
import { pathToFileURL } from "node:url";

const [folder] = process.argv.slice(2);
const load = (name) => import(pathToFileURL(`${folder}/${name}.js`));
const { clock, outline, ticks, within } = await load("timeline/scales");
const { arraysOf, filled } = await load("line/unpack");
const { composed, placed, times, FaceShape } = await load("face/face_shape");
const { turned } = await load("face/gl_face");
const { mouthOf } = await load("face/drawn_mouth");
const { wave } = await load("line/player");
const { onsets, snappedTo } = await load("timeline/onsets");
const { withKey, withMoved } = await load("timeline/bend_points");
const { placedAt, secondsOf, shownGestures, withMovedGesture, withoutGesture, withScaledGesture } = await load("timeline/gesture_places");
const { transform } = await load("timeline/spectrogram");
const { sphere } = await load("face/ambient");
const { Take } = await load("line/take");
const { movingRows } = await load("line/take_words");
const { beside, editsOf, occurrences, spoken } = await load("views/bigram_state");
const { levelAt, movedPoint, withoutPoint, withPoint, withWord } = await load("timeline/level_points");
const { asText, changedBy, everyPoint, fromText, inserted, scaled, shifted, snapped, typed, without } = await load("curves/curve_points");
const { dominanceOf, stepsOf, targetOf, weightsOf, withDominance, withWeight, withWeights } = await load("views/target_forms");
const { innerKinds, NEAR, OUTER, TONGUE } = await load("face/inner_mouth");

const near = (a, b, most = 1e-6) => {
  assert.equal(a.length, b.length);
  a.forEach((one, n) => assert.ok(Math.abs(one - b[n]) <= most, `${[...a]} is not ${[...b]}`));
};
const REST = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
const HALF = Math.SQRT1_2;

/** A triangle, the third point of which one channel lifts by 1; the node turns by another. */
function face(more = {}) {
  return {
    count: 3,
    nodes: [{ parent: -1, matrix: REST }],
    parts: [{
      node: 0, first: 0, count: 3, middle: [0, 0, 0], scale: 1, points: [0, 0, 0, 1, 0, 0, 0, 1, 0], skin: null,
      shapes: [{ channels: [0, 2], rest: 0, scale: 0.5, points: [2], deltas: [0, 2, 0] }],
    }],
    triangles: Uint16Array.of(0, 1, 2), groups: Uint16Array.of(0, 1, 2),
    normals: new Int8Array(9), moving: Uint8Array.of(0, 0, 1), ...more,
  };
}

/** A head of one quad, a tongue of one that a channel lifts, and a tooth above it. */
function mouth(joined) {
  const quad = (x, size, z) => [x, 0, z, x + size, 0, z, x, size, z, x + size, size, z];
  const two = (n) => [n, n + 1, n + 2, n + 1, n + 3, n + 2];
  const groups = Uint16Array.from({ length: 12 }, (_, n) => (joined && n === 4 ? 3 : n));
  return {
    ...face(), count: 12, groups, triangles: Uint16Array.of(...two(0), ...two(4), ...two(8)), normals: new Int8Array(36), moving: new Uint8Array(12).fill(1),
    parts: [{
      node: 0, first: 0, count: 12, middle: [0, 0, 0], scale: 1, points: [...quad(0, 10, 0), ...quad(4, 2, -1), ...quad(4.5, 1, -0.5)], skin: null,
      shapes: [{ channels: [0], rest: 0, scale: 1, points: [4, 5, 6, 7], deltas: [0, 0, joined ? 0 : 0.5, 0, 0, 1, 0, 0, 1, 0, 0, 1] }],
    }],
  };
}

const units = {
  "onsets are where a sound rises, and a boundary snaps to them"() {
    const rate = 8000, samples = Int16Array.from({ length: rate }, (_, n) => (n % 4000 < 2000 ? 0 : 9000 * Math.sin(n / 3)));
    const found = onsets(samples, rate);
    near(found, [0.25, 0.75], 0.011);
    assert.equal(snappedTo(0.26, found, 0.03), found[0]);
    assert.equal(snappedTo(0.4, found, 0.03), 0.4);
    assert.equal(snappedTo(0.4, [], 1), 0.4);
    assert.deepEqual(onsets(new Int16Array(0), rate), []);
  },
  "a key bends its surroundings alone"() {
    assert.deepEqual(withKey([], 1, 0.5), [[[1, 0.5]], 0]);
    assert.deepEqual(withKey([[1, 0.5]], 1.005, -0.2), [[[1, -0.2]], 0]);
    assert.deepEqual(withKey([[1, 0.5]], 1.1, 0.2), [[[1, 0.5], [1.1, 0.2]], 1]);
    assert.deepEqual(withKey([[1, 0.5]], 2, 0.2), [[[1, 0.5], [1.12, 0], [1.88, 0], [2, 0.2]], 3]);
    assert.deepEqual(withKey([[2, 0.2]], 1, 0.5), [[[1, 0.5], [1.12, 0], [1.88, 0], [2, 0.2]], 0]);
    assert.deepEqual(withMoved([[1, 0], [2, 0]], 0, 3, -4), [[2, -1], [2, 0]]);
  },
  "a gesture keeps its place beside a word"() {
    const spoken = { times: [0.2, 0.5, 0.9, 1.4], words: [["a", 0, 1], ["b", 1, 3]] };
    for (const [seconds, word, after] of [[0.1, 0, -0.1], [0.2, 0, undefined], [0.45, 0, 0.25], [0.5, 1, undefined], [2, 1, 1.5]]) {
      const one = placedAt("nod", seconds, 1, spoken);
      assert.deepEqual([one.word, one.after, one.at, one.scale], [word, after, undefined, undefined]);
      near([secondsOf(one, spoken)], [seconds]);
    }
    assert.deepEqual(placedAt("nod", 0.3, 0.5, { times: [0, 1], words: [] }), { gesture: "nod", at: 0.3, scale: 0.5 });
    assert.equal(secondsOf({ gesture: "nod", at: 0.3 }, spoken), 0.3);
  },
  "a part of a line shows its own gestures by hand"() {
    const spoken = { times: [9, 10, 11, 12], words: [["a", 0, 1], ["b", 1, 3]], first: 7 };
    assert.deepEqual(placedAt("nod", 10.2, 1, spoken), { gesture: "nod", word: 8, after: 0.2 });
    near([secondsOf({ gesture: "nod", word: 8, after: 0.2 }, spoken)], [10.2]);
    const placed = [{ word: 6 }, { word: 7 }, { word: 9 }, { at: 3 }, { at: 11.5 }].map((one) => ({ gesture: "nod", ...one }));
    const took = { kinds: [{ name: "nod", lead: 0.1, seconds: 0.5, room: 0.5 }], rows: [] };
    assert.deepEqual(shownGestures(took, placed, spoken).map((one) => [one.hand, one.at]), [[1, 9], [4, 11.5]]);
  },
  "gestures by hand keep those by rule away"() {
    const spoken = { times: [0, 1, 2, 3], words: [["a", 0, 1], ["b", 1, 2], ["c", 2, 3]] };
    const kinds = [{ name: "nod", lead: 0.1, seconds: 0.5, room: 0.5 }];
    const ruled = { name: "nod", at: 1, begin: 0.9, scale: 0.7, why: "stress", hand: -1 }, took = { kinds, rows: [ruled] };
    const show = (placed) => shownGestures(took, placed, spoken).map((one) => [one.at, one.scale, one.hand]);
    assert.deepEqual(show([]), [[1, 0.7, -1]]);
    assert.deepEqual(show([{ gesture: "nod", word: 2 }]), [[2, 1, 0], [1, 0.7, -1]]);
    assert.deepEqual(show([{ gesture: "nod", at: 1.4 }]), [[1.4, 1, 0]]);
    assert.deepEqual(show([{ gesture: "blink", at: 1 }]), [[1, 0.7, -1]], "a gesture that is off has no place");
    const [own] = shownGestures(took, [], spoken), [moved, hand] = withMovedGesture([], own, 2.5, spoken);
    near([own.begin, own.end], [0.9, 1.4]);
    assert.deepEqual(moved, [{ gesture: "nod", word: 1, scale: 0 }, { gesture: "nod", word: 2, after: 0.5, scale: 0.7 }]);
    assert.equal(hand, 1);
    const again = shownGestures(took, moved, spoken)[hand];
    assert.deepEqual(withMovedGesture(moved, again, 0, spoken), [[moved[0], { gesture: "nod", word: 0, scale: 0.7 }], 1]);
    assert.deepEqual(withScaledGesture(moved, again, 1, spoken), [[moved[0], { gesture: "nod", word: 2, after: 0.5 }], 1]);
    assert.deepEqual(withScaledGesture([], own, 2, spoken), [[{ gesture: "nod", word: 1, scale: 2 }], 0]);
    assert.deepEqual(withoutGesture([], own, spoken), [[moved[0]], 0]);
    assert.deepEqual(withoutGesture(moved, again, spoken), [[moved[0]], -1]);
  },
  "a transform finds the frequency of a tone"() {
    const real = Float32Array.from({ length: 64 }, (_, n) => Math.cos((2 * Math.PI * 5 * n) / 64)), imaginary = new Float32Array(64);
    transform(real, imaginary);
    near([...real.subarray(0, 8)], [0, 0, 0, 0, 0, 32, 0, 0], 1e-3);
  },
  "a target keeps its form where it is changed"() {
    const flat = { a: 0.5, b: 0, dominance: { b: 2 } }, whole = { weights: { a: 1 }, overall: 3 };
    assert.deepEqual(stepsOf(undefined), []);
    assert.equal(targetOf(stepsOf(flat)), flat);
    assert.equal(targetOf([flat, whole]).length, 2);
    assert.deepEqual(weightsOf(flat), { a: 0.5, b: 0 });
    assert.deepEqual(weightsOf(whole), { a: 1 });
    assert.deepEqual(dominanceOf({ a: 1, dominance: 0.3 }), { overall: 0.3, poses: {} });
    assert.deepEqual(dominanceOf(whole), { overall: 3, poses: {} });
    assert.equal(JSON.stringify(withWeight(flat, "c", 0.2)), '{"a":0.5,"b":0,"c":0.2,"dominance":{"b":2}}');
    assert.equal(JSON.stringify(withWeight(flat, "a", 0.2)), '{"a":0.2,"b":0,"dominance":{"b":2}}');
    assert.deepEqual(withWeight(whole, "a", null), { weights: {}, overall: 3 });
    assert.deepEqual(withWeights(flat, { a: 0, b: 0, c: 0.5, d: 0 }), { a: 0, b: 0, c: 0.5, dominance: { b: 2 } });
    assert.deepEqual(withDominance(flat, "b", null), { a: 0.5, b: 0 });
    assert.deepEqual(withDominance({ a: 1 }, null, 0.5), { a: 1, dominance: 0.5 });
    assert.deepEqual(withDominance(flat, null, 0.5), { weights: { a: 0.5, b: 0 }, dominance: { b: 2 }, overall: 0.5 });
    assert.deepEqual(withDominance(whole, null, null), { weights: { a: 1 } });
    const fitted = [{ ...flat, status: "fitted" }, { ...whole, status: "fitted" }];
    assert.deepEqual(fitted.map(weightsOf), [{ a: 0.5, b: 0 }, { a: 1 }]);
    assert.deepEqual(targetOf(fitted), [flat, whole]);
    assert.deepEqual(withWeight(fitted[0], "b", null), { a: 0.5, dominance: { b: 2 } });
  },
  "the tongue is what its poses move, and the teeth are near it"() {
    const apart = innerKinds(new FaceShape(mouth(false)), [0], [[1]]);
    assert.deepEqual([...apart], [OUTER, OUTER, TONGUE, TONGUE, NEAR, NEAR]);
    const joined = innerKinds(new FaceShape(mouth(true)), [0], [[1]]);
    assert.deepEqual([...joined], [OUTER, OUTER, OUTER, TONGUE, OUTER, OUTER]);
    assert.equal(innerKinds(new FaceShape(mouth(false)), [0], [[0]]), null);
  },
  "ticks are round and inside"() {
    assert.deepEqual(ticks(0.05, 1.02, 5), [0.2, 0.4, 0.6, 0.8, 1]);
    assert.deepEqual(ticks(-0.25, 0.25, 6), [-0.2, -0.1, 0, 0.1, 0.2]);
  },
  "times are read by people"() {
    assert.equal(clock(0.5), "0.50 s");
    assert.equal(clock(-0.2), "−0.20 s");
    assert.equal(clock(62.5), "1:02.50");
    assert.equal(clock(120, 0), "2:00");
  },
  "a span stays within the line"() {
    assert.deepEqual(within(-1, 1, 0, 3), [0, 2]);
    assert.deepEqual(within(2.5, 4.5, 0, 3), [1, 3]);
    assert.deepEqual(within(0, 9, 0, 3), [0, 3]);
    near(within(1, 1.01, 0, 3, 0.1), [1, 1.1]);
  },
  "an outline has the loudest samples"() {
    const samples = Int16Array.from({ length: 100 }, (_, n) => (n === 50 ? 16384 : 0));
    const shape = outline(samples, 100, 0, 1, 10);
    assert.deepEqual(shape.map(([, high]) => high), [0, 0, 0, 0, 0, 0.5, 0, 0, 0, 0]);
    assert.deepEqual(outline(samples, 100, -1, 0, 2), [[0, 0], [0, 0]]);
  },
  "differences of numbers are undone"() {
    const [u2, i2, u1] = arraysOf(Uint8Array.of(1, 254, 0, 255, 255, 255, 7), [["u2", 2], ["i2", 1], ["u1", 1]]);
    assert.deepEqual([...u2], [1, 65535]);
    assert.deepEqual([[...i2], [...u1]], [[-1], [7]]);
    assert.deepEqual(filled({ a: [{ $array: 1 }], b: null }, [1, 2]), { a: [2], b: null });
  },
  "matrices act on rows"() {
    const shift = placed([1, 2, 3], [0, 0, 0, 1], [2, 2, 2]);
    near(shift, [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1]);
    near(times(shift, shift).slice(12, 15), [3, 6, 9]);
    const quarter = placed([0, 0, 0], [0, 0, HALF, HALF], [1, 1, 1]);
    near(quarter.slice(0, 4), [0, 1, 0, 0]);
    near(composed([0, 0, HALF, HALF], [0, 0, HALF, HALF]), [0, 0, 1, 0]);
  },
  "the larger of two channels moves a shape"() {
    const shape = new FaceShape(face());
    shape.move([0.25, 0, 0.75]);
    near(shape.points.slice(6), [0, 1.75, 0]);
    near(shape.normals.slice(0, 3), [0, 0, 1]);
  },
  "a bone turns by degrees, then its children"() {
    const nodes = [
      { parent: -1, translation: [0, 0, 0], rotation: [0, 0, 0, 1], scale: [1, 1, 1], moves: [{ channel: 1, turn: [0, 0, 2], shift: [0, 0, 1] }] },
      { parent: 0, matrix: REST },
    ];
    const one = face({ nodes });
    one.parts[0].node = 1;
    const shape = new FaceShape(one);
    shape.move([0, 90, 0]);
    near(shape.points.slice(3, 6), [0, 1, 90], 1e-5);
  },
  "a skin shares its points among bones"() {
    const one = face({ nodes: [{ parent: -1, matrix: REST }, { parent: -1, matrix: placed([0, 0, 4], [0, 0, 0, 1], [1, 1, 1]) }] });
    one.parts[0].skin = {
      bones: [0, 1], inverse: Float32Array.from([...REST, ...REST]), sets: 2,
      joints: Uint16Array.of(0, 1, 0, 1, 0, 1), shares: Uint16Array.of(65535, 0, 0, 65535, 32768, 32767),
    };
    const shape = new FaceShape(one);
    near([shape.points[2], shape.points[5], shape.points[8]], [0, 4, 2], 1e-3);
  },
  "normals of the file turn with the surface"() {
    const tilted = face({ normals: Int8Array.of(127, 0, 0, 127, 0, 0, 127, 0, 0) });
    near(new FaceShape(tilted).normals.slice(0, 3), [1, 0, 0], 1e-6);
  },
  "the view turns to the side"() {
    const rest = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    near(turned(rest, 0, 0), [1, 0, 0, 0, 1, 0, 0, 0, 1]);
    near(turned(rest, 90, 0), [0, 0, -1, 0, 1, 0, 1, 0, 0]);
  },
  "a mouth is read from measures, within its limits"() {
    const measures = { aperture: { a: 1, b: -1 }, protrusion: { b: 9 } };
    const mouth = mouthOf(measures, ["a", "b"], [0.25, 0.5]);
    near([mouth.aperture, mouth.protrusion, mouth.tip], [-0.25, 1.1, 0]);
  },
  "a wave has silence before its sound"() {
    const bytes = wave(Int16Array.of(5, 6, 7), 10, -0.2, 0.2);
    assert.deepEqual([...new Int16Array(bytes.buffer, 44)], [0, 0, 5, 6]);
    assert.deepEqual([...new Int16Array(wave(Int16Array.of(5, 6, 7), 10, 0.1, 0.2).buffer, 44)], [6]);
  },
  "directions are even and of length 1"() {
    near(sphere(40).map((way) => Math.hypot(...way)), Array(40).fill(1));
    const sum = sphere(40).reduce((total, way) => total.map((one, k) => one + way[k]), [0, 0, 0]);
    near(sum, [0, 0, 0], 1);
  },
  "channels of a rig are rows of their own"() {
    const curve = (most) => ({ low: 0, high: most, moves: most > 1, values: Uint16Array.of(0, 65535) });
    const take = new Take({
      poses: ["open"], start: 0, fps: 10, count: 2, curves: [curve(1)], channels: { poses: ["open"], curves: [curve(20)] },
    });
    assert.deepEqual([...take.rows.keys()], ["open", "rig: open"]);
    assert.deepEqual([take.weight("open", 1), take.weight("rig: open", 1), take.moving], [1, 20, ["rig: open"]]);
    near(take.channelsAt(0.1), [20]);
  },
  "mirrored poses that move alike are one row, which can be opened"() {
    const curve = (...values) => ({ low: 0, high: 1, moves: true, values: Uint16Array.from(values) });
    const take = (right) => new Take({
      poses: ["jaw", "smileLeft", "smileRight"], mirrored: { smile: ["smileLeft", "smileRight"] },
      start: 0, fps: 10, count: 2, curves: [curve(0, 9), curve(1, 5), curve(1, right)],
    });
    const alike = take(5), apart = take(6), crab = new Take({ ...alike.data, poses: ["jaw"], curves: [curve(0, 1)] });
    const [one, two] = [["jaw", "smile"], ["jaw", "smileLeft", "smileRight"]];
    assert.deepEqual(movingRows(alike, null, new Set()), one);
    assert.deepEqual(movingRows(alike, crab, new Set()), one);
    assert.deepEqual(movingRows(alike, null, new Set(["smile"])), two);
    for (const takes of [[apart, null], [alike, apart], [apart, alike]]) {
      assert.deepEqual(movingRows(...takes, new Set()), two);
    }
    assert.equal(alike.weight("smile", 1), alike.weight("smileRight", 1));
  },
  "a take without its making tells its sounds"() {
    const values = Uint16Array.of(0, 65535, 0);
    const take = new Take({
      name: "", poses: ["a"], start: 0, fps: 10, count: 3, curves: [{ low: -1, high: 1, moves: true, values }],
      spoken: { times: [0, 0.1, 0.2], labels: ["M", "AA"], words: [["ma", 0, 2]] }, figures: [], measures: {},
    });
    assert.equal(take.soundAt(1).label, "AA");
    assert.equal(take.soundAt(1).word, "ma");
    assert.equal(take.frameAt(9), 2);
    assert.equal(take.weight("a", 1), 1);
    assert.deepEqual(take.moving, ["a"]);
    near(take.channelsAt(0.05), [0]);
    assert.deepEqual([take.stepsAt(0, 1), take.bigramsAt(1)], [[], []]);
  },
  "points keep their order and their range"() {
    const curves = { a: [[0, 0], [0.4, 0.5], [0.6, 1], [1, 0]], b: [[0, 0], [1, 0]] };
    const one = new Map([["a", new Set([1])]]), two = new Map([["a", new Set([1, 2])]]);
    assert.deepEqual(shifted(curves, one, 0.1, 0.2).a[1], [0.5, 0.7]);
    assert.deepEqual(shifted(curves, one, 0.5, -2).a[1], [0.6, 0]);
    assert.deepEqual(shifted(curves, two, 0.9, 0.3).a, [[0, 0], [0.8, 0.5], [1, 1], [1, 0]], "a value at its limit holds the others");
    assert.equal(shifted(curves, two, 0.9, 0.3).b, curves.b);
    assert.deepEqual(curves.a[1], [0.4, 0.5]);
  },
  "points are scaled, times about a moment and values about nothing"() {
    const curves = { a: [[0, 0], [0.4, 0.5], [0.6, 1], [1, 0]] }, two = new Map([["a", new Set([1, 2])]]);
    assert.deepEqual(scaled(curves, two, 2, 0.5, 0.4).a, [[0, 0], [0.4, 0.25], [0.8, 0.5], [1, 0]]);
    assert.deepEqual(scaled(curves, two, 9, 3, 0.4).a, [[0, 0], [0.4, 1], [1, 1], [1, 0]]);
    assert.deepEqual(scaled(curves, two, -1, -1, 0.4).a.slice(1, 3), [[0.4, 0], [0.4, 0]]);
  },
  "numbers are snapped to their step"() {
    assert.deepEqual([snapped(0.374, 0.05), snapped(0.376, 0.05), snapped(0.3337, 0.01), snapped(0.33372)], [0.35, 0.4, 0.33, 0.334]);
  },
  "a typed number sets, shifts or scales"() {
    assert.deepEqual(typed("0.4"), { does: "set", amount: 0.4 });
    assert.deepEqual(typed(" +,1 "), { does: "shift", amount: 0.1 });
    assert.deepEqual(typed("−.25"), { does: "shift", amount: -0.25 });
    assert.deepEqual(typed("*0.8"), { does: "scale", amount: 0.8 });
    assert.deepEqual(typed("80%"), { does: "scale", amount: 0.8 });
    assert.deepEqual(["", "a", "1e3", "+80%", "--1"].map(typed), [null, null, null, null, null]);
    const curves = { a: [[0, 0], [0.4, 0.5], [0.6, 1], [1, 0]] }, two = new Map([["a", new Set([1, 2])]]);
    const after = (axis, text) => changedBy(curves, two, axis, typed(text)).a.slice(1, 3);
    assert.deepEqual([after(0, "0.2"), after(0, "200%")], [[[0.2, 0.5], [0.4, 1]], [[0.4, 0.5], [0.8, 1]]]);
    assert.deepEqual([after(1, "2"), after(1, "-0.1")], [[[0.4, 1], [0.6, 1]], [[0.4, 0.4], [0.6, 0.9]]]);
  },
  "points come and go; a curve of one point goes"() {
    const curves = { a: [[0, 0], [0.4, 0.5], [1, 0]] };
    assert.deepEqual(inserted(curves.a, 0.7, 3), { points: [[0, 0], [0.4, 0.5], [0.7, 1], [1, 0]], index: 2 });
    assert.deepEqual(inserted(curves.a, -1, 0).index, 1);
    assert.deepEqual(without(curves, new Map([["a", new Set([1])]])), { a: [[0, 0], [1, 0]] });
    assert.deepEqual(without(curves, new Map([["a", new Set([0, 1])]])), {});
    assert.deepEqual([...everyPoint(curves)], [["a", new Set([0, 1, 2])]]);
  },
  "only sound curves are pasted"() {
    const curves = { a: [[0, 0], [0.4, 0.5], [1, 0]] };
    assert.deepEqual(fromText(asText(curves)), curves);
    const unsound = [{ a: [[0, 0]] }, { a: [[1, 0], [0, 0]] }, { a: [[0, 2], [1, 0]] }, { a: [[0], [1, 0]] }, { a: [["0", null], [1, 0]] }, {}];
    assert.deepEqual(["", "null", "{}", JSON.stringify({ curves }), ...unsound.map(asText)].map(fromText), Array(10).fill(null));
  },
  "edits say what changed of a bigram, and no more"() {
    const before = { curves: { a: [[0, 0], [1, 0]], b: [[0, 1], [1, 1]] }, boundary: 0.4, interpolation: "", contact: "free", status: "drafted", word: "low", why: "" };
    const after = { ...before, curves: { a: [[0, 0], [1, 0.5]], c: [[0, 0], [1, 1]] }, contact: "hold", status: "edited", why: "round" };
    const at = ["bigrams", "l-ow"], file = "bank";
    assert.deepEqual(editsOf("bank", "l-ow", before, before), []);
    assert.deepEqual(editsOf("bank", "l-ow", before, after), [
      { file, at: [...at, "status"], value: "edited" }, { file, at: [...at, "contact"] }, { file, at: [...at, "why"], value: "round" },
      { file, at: [...at, "curves", "a"], value: after.curves.a }, { file, at: [...at, "curves", "b"] }, { file, at: [...at, "curves", "c"], value: after.curves.c },
    ]);
    assert.deepEqual(editsOf("bank", "l-ow", null, after), [{ file, at, value: { word: "low", status: "edited", boundary: 0.4, why: "round", curves: after.curves } }]);
    assert.deepEqual(editsOf("bank", "l-ow", before, { ...before, curves: {} }), [{ file, at: [...at, "curves"], value: {} }]);
  },
  "a neighbour lies where its phoneme does"() {
    near(beside({ a: [[0.2, 0.1], [0.6, 0.5], [1, 0.9]] }, 0.6, 0.4, "before").a.map(([t]) => t), [-0.4, 0, 0.4]);
    near(beside({ a: [[0, 0.1], [0.5, 0.5], [1, 0.9]] }, 0.5, 0.4, "after").a.map(([t]) => t), [0.4, 1, 1.6]);
  },
  "a bigram is found in the line, nearest to a moment"() {
    const FULL = 65535, curve = { low: 0, high: 1, moves: true, values: new Uint16Array(7) };
    const bigrams = ["_-m", "m-a", "a-m", "m-a", "a-_"].map((pair) => ({ pair }));
    const places = [[FULL, 1, 2, 3, 4, 5, 6], [0, FULL / 2, 0, 0, 0, 0, 0]].map((one) => Uint16Array.from(one));
    const spokenLine = { words: [["ma", 1, 3], ["m", 3, 4], ["a", 4, 5]], labels: [], times: [] };
    const take = new Take({ poses: ["x"], start: 0, fps: 10, count: 7, curves: [curve], spoken: spokenLine, making: {
      moving: [], stages: [], bigrams, said: [0, 1, 2, 3, 4], source: [-1, 1, 2, 3, 4, -1], bounds: [0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6], phoneme: Uint16Array.of(0, 1, 2, 3, 4, 5, 5), places,
    } });
    assert.deepEqual(spoken(take, "m-a", 0), { seconds: 0.2, before: "_-m", after: "a-m", word: "ma" });
    assert.deepEqual(spoken(take, "m-a", 0.5), { seconds: 0.4, before: "a-m", after: "a-_", word: "" });
    assert.equal(spoken(take, "m-a", 0, 0.45).seconds, 0.1);
    assert.equal(spoken(take, "o-o", 0), null);
    assert.deepEqual(occurrences(take, "m-a"), [[0.1, 0.3], [0.3, 0.5]]);
  },
  "a level is straight between its points, and level around them"() {
    assert.equal(levelAt(0.5, 3), 0.5);
    near([0, 1, 1.5, 2, 9].map((at) => levelAt([[1, 0], [2, 1]], at)), [0, 0, 0.5, 1, 1]);
    near([0, 1, 2].map((at) => levelAt([[1, 0.2], [1, 0.8]], at)), [0.2, 0.8, 0.8]);
  },
  "a word has its own level, and the rest stays"() {
    const one = withWord(1, 1, 2, 0.5, 0, 3);
    near([0, 0.9, 1, 1.5, 2, 2.1, 3].map((at) => levelAt(one, at)), [1, 1, 0.5, 0.5, 0.5, 1, 1]);
    const two = withWord(one, 2, 2.5, 2, 0, 3);
    near([0.9, 1.5, 2, 2.4, 2.6].map((at) => levelAt(two, at)), [1, 0.5, 2, 2, 1]);
    const edge = withWord(1, 0, 3, 0, 0, 3);
    near([0, 1, 3].map((at) => levelAt(edge, at)), [0, 0, 0]);
    assert.ok([one, two, edge].every((points) => points.every(([at], n) => !n || at >= points[n - 1][0])));
  },
  "points keep their order and range"() {
    const [points, at] = withPoint([[0, 1], [2, 1]], [1, 1.234]);
    assert.deepEqual([points, at], [[[0, 1], [1, 1.23], [2, 1]], 1]);
    assert.deepEqual(movedPoint(points, 1, [9, 9], 2), [[0, 1], [2, 2], [2, 1]]);
    assert.deepEqual(movedPoint(points, 1, [-9, -9], 2), [[0, 1], [0, 0], [2, 1]]);
    assert.deepEqual(withoutPoint(points, 1), [[0, 1], [2, 1]]);
    assert.equal(withoutPoint([[0, 1], [2, 0.5]], 0), 0.5);
  },
};

const failed = [];
for (const [name, unit] of Object.entries(units)) {
  try { unit(); } catch (error) { failed.push(`${name}: ${error.message}`); }
}
console.log(JSON.stringify({ failed }));
