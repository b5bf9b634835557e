"""Where vertices of glTF files are at times of their animations, by an evaluator of its own: numpy, struct and json.

    python3 evaluate.py DATA > poses.json      writes what the test of poses compares with
    python3 evaluate.py DATA poses.json        checks that file

It shares no code with dotwork and knows nothing of it but the order in which vertices come: nodes of the default scene depth
first, of each mesh the primitives whose attributes differ from those before.
"""
import base64, json, os, struct, sys
import numpy as np

KINDS = {5120: ("b", 127.0), 5121: ("B", 255.0), 5122: ("h", 32767.0), 5123: ("H", 65535.0), 5125: ("I", None), 5126: ("f", None)}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
FILES = [
    ("fox.glb", [0, 1, 2]), ("cesiumman.glb", [0]), ("morphstresstest.glb", [0, 1, 2]), ("riggedsimple.glb", [0]),
    ("simple_skin.gltf", [0]), ("sparse_blendshape_cube.glb", None), ("animatedmorphcube/AnimatedMorphCube.gltf", [0]),
]
EVERY = 37


class File:
    def __init__(self, path):
        data = open(path, "rb").read()
        binary = None
        if data[:4] == b"glTF":
            at, chunks = 12, []
            while at < len(data):
                length, kind = struct.unpack_from("<II", data, at)
                chunks.append((kind, data[at + 8:at + 8 + length]))
                at += 8 + length
            self.json = json.loads(chunks[0][1])
            binary = chunks[1][1] if len(chunks) > 1 else None
        else:
            self.json = json.loads(data)
        self.buffers = []
        for buffer in self.json.get("buffers", []):
            uri = buffer.get("uri")
            if uri is None:
                self.buffers.append(binary)
            elif uri.startswith("data:"):
                self.buffers.append(base64.b64decode(uri.split(",", 1)[1]))
            else:
                self.buffers.append(open(os.path.join(os.path.dirname(path), uri), "rb").read())

    def raw(self, view, offset, count, letter, width):
        view = self.json["bufferViews"][view]
        size = struct.calcsize(letter) * width
        start = view.get("byteOffset", 0) + offset
        stride = view.get("byteStride", size)
        data = self.buffers[view["buffer"]]
        rows = [struct.unpack_from("<" + letter * width, data, start + k * stride) for k in range(count)]
        return np.array(rows, dtype=np.float64).reshape(count, width)

    def accessor(self, index):
        a = self.json["accessors"][index]
        letter, scale = KINDS[a["componentType"]]
        width = WIDTHS[a["type"]]
        if "bufferView" in a:
            values = self.raw(a["bufferView"], a.get("byteOffset", 0), a["count"], letter, width)
        else:
            values = np.zeros((a["count"], width))
        if "sparse" in a:
            s = a["sparse"]
            which = self.raw(s["indices"]["bufferView"], s["indices"].get("byteOffset", 0), s["count"], KINDS[s["indices"]["componentType"]][0], 1)
            values[which[:, 0].astype(int)] = self.raw(s["values"]["bufferView"], s["values"].get("byteOffset", 0), s["count"], letter, width)
        if a.get("normalized") and scale:
            values = np.maximum(values / scale, -1.0)
        return values


def matrix(t, r, s):
    x, y, z, w = np.array(r) / np.linalg.norm(r)
    turn = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])
    m = np.eye(4)
    m[:3, :3] = turn * np.array(s)
    m[:3, 3] = t
    return m


def slerp(a, b, t):
    d = np.dot(a, b)
    if d < 0:
        b, d = -b, -d
    angle = np.arccos(min(d, 1.0))
    if np.sin(angle) < 1e-7:
        return a + (b - a) * t
    return (np.sin((1 - t) * angle) * a + np.sin(t * angle) * b) / np.sin(angle)


def sample(file, sampler, time, width, turn):
    times = file.accessor(sampler["input"])[:, 0]
    values = file.accessor(sampler["output"]).reshape(-1)
    kind = sampler.get("interpolation", "LINEAR")
    cubic = kind == "CUBICSPLINE"
    rows = values.reshape(len(times), 3 if cubic else 1, width)
    value = lambda k: rows[k, 1 if cubic else 0]
    if time <= times[0]:
        return value(0)
    if time >= times[-1]:
        return value(len(times) - 1)
    k = int(np.searchsorted(times, time, side="right")) - 1
    h = times[k + 1] - times[k]
    t = (time - times[k]) / h
    if kind == "STEP":
        return value(k)
    if cubic:
        return ((2 * t**3 - 3 * t**2 + 1) * value(k) + h * (t**3 - 2 * t**2 + t) * rows[k, 2]
                + (-2 * t**3 + 3 * t**2) * value(k + 1) + h * (t**3 - t**2) * rows[k + 1, 0])
    if turn:
        a, b = value(k) / np.linalg.norm(value(k)), value(k + 1) / np.linalg.norm(value(k + 1))
        return slerp(a, b, t)
    return value(k) + (value(k + 1) - value(k)) * t


def pose(file, clip, time):
    nodes = file.json["nodes"]
    parts = [[n.get("translation", [0, 0, 0]), n.get("rotation", [0, 0, 0, 1]), n.get("scale", [1, 1, 1])] for n in nodes]
    weights = {}
    if clip is not None:
        animation = file.json["animations"][clip]
        for channel in animation["channels"]:
            node, path = channel["target"].get("node"), channel["target"]["path"]
            sampler = animation["samplers"][channel["sampler"]]
            if node is None:
                continue
            if path == "weights":
                mesh = file.json["meshes"][nodes[node]["mesh"]]
                weights[node] = sample(file, sampler, time, len(mesh["primitives"][0]["targets"]), False)
            else:
                which = ["translation", "rotation", "scale"].index(path)
                parts[node][which] = sample(file, sampler, time, [3, 4, 3][which], which == 1)
    local = []
    for n, p in zip(nodes, parts):
        local.append(np.array(n["matrix"]).reshape(4, 4).T if "matrix" in n else matrix(*p))
    glob = [None] * len(nodes)
    child_of = {c: n for n, node in enumerate(nodes) for c in node.get("children", [])}

    def find(n):
        if glob[n] is None:
            glob[n] = find(child_of[n]) @ local[n] if n in child_of else local[n]
        return glob[n]

    for n in range(len(nodes)):
        find(n)
    return glob, weights


def vertices(file, clip, time):
    glob, weights = pose(file, clip, time)
    nodes = file.json["nodes"]
    roots = file.json["scenes"][file.json.get("scene", 0)]["nodes"]
    order, stack = [], list(reversed(roots))
    while stack:
        n = stack.pop()
        order.append(n)
        stack.extend(reversed(nodes[n].get("children", [])))
    out = []
    for n in order:
        node = nodes[n]
        if "mesh" not in node:
            continue
        mesh = file.json["meshes"][node["mesh"]]
        seen = set()
        for primitive in mesh["primitives"]:
            a = primitive["attributes"]
            names = ["POSITION", "COLOR_0", "JOINTS_0", "WEIGHTS_0", "JOINTS_1", "WEIGHTS_1"]
            key = (tuple(a.get(k) for k in names), tuple(t.get("POSITION") for t in primitive.get("targets", [])))
            if primitive.get("mode", 4) < 4 or key in seen:
                continue
            seen.add(key)
            p = file.accessor(a["POSITION"])
            w = weights.get(n, node.get("weights", mesh.get("weights", [])))
            for weight, target in zip(w, primitive.get("targets", [])):
                if "POSITION" in target and weight != 0:
                    p = p + weight * file.accessor(target["POSITION"])
            p = np.hstack([p, np.ones((len(p), 1))])
            if "skin" in node and "JOINTS_0" in a:
                skin = file.json["skins"][node["skin"]]
                joints = skin["joints"]
                bind = file.accessor(skin["inverseBindMatrices"]) if "inverseBindMatrices" in skin else None
                joint = [glob[j] @ (bind[k].reshape(4, 4).T if bind is not None else np.eye(4)) for k, j in enumerate(joints)]
                sum_, total = np.zeros_like(p), np.zeros(len(p))
                for suffix in ["0", "1"]:
                    if "JOINTS_" + suffix not in a:
                        continue
                    js, ws = file.accessor(a["JOINTS_" + suffix]).astype(int), file.accessor(a["WEIGHTS_" + suffix])
                    for c in range(4):
                        m = np.array([joint[j] for j in js[:, c]])
                        sum_ += ws[:, c, None] * np.einsum("vij,vj->vi", m, p)
                        total += ws[:, c]
                p = sum_ / total[:, None]
            else:
                p = p @ glob[n].T
            out.append(p[:, :3])
    return np.vstack(out)


def poses(folder):
    found = []
    for name, clips in FILES:
        file = File(os.path.join(folder, name))
        for clip in clips if clips is not None else range(len(file.json.get("animations", []))):
            samplers = file.json["animations"][clip]["samplers"]
            end = max(file.accessor(s["input"])[-1, 0] for s in samplers)
            for share in [0.0, 0.137, 0.5, 0.731, 1.0]:
                time = round(float(end) * share, 4)
                all_ = vertices(file, clip, time)
                size = float(np.linalg.norm(all_.max(0) - all_.min(0)))
                some = {str(v): [round(float(c), 7) for c in all_[v]] for v in range(0, len(all_), EVERY)}
                found.append({"file": name, "clip": clip, "time": time, "vertices": len(all_), "size": round(size, 5), "places": some})
    return found


if __name__ == "__main__":
    made = poses(sys.argv[1])
    if len(sys.argv) == 2:
        print("[\n" + ",\n".join(json.dumps(p, separators=(",", ":")) for p in made) + "\n]")
    else:
        kept = json.load(open(sys.argv[2]))
        assert len(kept) == len(made), (len(kept), len(made))
        for a, b in zip(made, kept):
            assert [a[k] for k in ("file", "clip", "time", "vertices")] == [b[k] for k in ("file", "clip", "time", "vertices")]
            for v, p in a["places"].items():
                far = float(np.abs(np.array(p) - np.array(b["places"][v])).max())
                assert far <= 1e-6 * max(a["size"], 1.0), (a["file"], a["time"], v, far)
        print(f"{len(made)} poses agree")
