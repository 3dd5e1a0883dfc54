// A four-legged animal as a surface around bones, by naive surface nets, with a walk. Big enough figures make big meshes.

const BONES = {
  horse: [
    ['body', [-0.55, 0, 0], [0.5, 0.03, 0], 0.2],
    ['neck', [0.5, 0.08, 0], [0.8, 0.5, 0], 0.105],
    ['head', [0.8, 0.5, 0], [1.06, 0.38, 0], 0.085],
    ['ear.L', [0.8, 0.56, 0.05], [0.8, 0.68, 0.08], 0.025],
    ['ear.R', [0.8, 0.56, -0.05], [0.8, 0.68, -0.08], 0.025],
    ['tail', [-0.62, 0.08, 0], [-0.86, -0.25, 0], 0.04],
  ],
  camel: [
    ['body', [-0.5, 0, 0], [0.45, 0, 0], 0.21],
    ['hump', [-0.05, 0.2, 0], [0, 0.32, 0], 0.11],
    ['neck', [0.5, -0.02, 0], [0.74, -0.02, 0], 0.1],
    ['throat', [0.74, -0.02, 0], [0.98, 0.52, 0], 0.075],
    ['head', [0.98, 0.52, 0], [1.22, 0.5, 0], 0.085],
    ['ear.L', [0.97, 0.58, 0.05], [0.94, 0.66, 0.08], 0.025],
    ['ear.R', [0.97, 0.58, -0.05], [0.94, 0.66, -0.08], 0.025],
    ['tail', [-0.6, 0.02, 0], [-0.72, -0.25, 0], 0.03],
  ],
};

const LEGS = [
  ['front.L', 0.42, 0.13],
  ['front.R', 0.42, -0.13],
  ['back.L', -0.48, 0.13],
  ['back.R', -0.48, -0.13],
];

/** Points that have names, for proposals. */
export const NAMED = {
  horse: [
    ['nose', [1.15, 0.36, 0]],
    ['left ear', [0.8, 0.7, 0.085]],
    ['right ear', [0.8, 0.7, -0.085]],
    ['tail', [-0.88, -0.28, 0]],
    ['withers', [0.3, 0.25, 0]],
    ['rump', [-0.6, 0.2, 0]],
    ['belly', [0, -0.2, 0]],
    ...LEGS.map(([name, x, z]) => [`${name} foot`, [x, -0.95, z]]),
    ...LEGS.map(([name, x, z]) => [`${name} knee`, [x + 0.05, -0.5, z]]),
  ],
  camel: [
    ['nose', [1.31, 0.5, 0]],
    ['left ear', [0.94, 0.68, 0.085]],
    ['right ear', [0.94, 0.68, -0.085]],
    ['tail', [-0.74, -0.28, 0]],
    ['withers', [0.3, 0.22, 0]],
    ['rump', [-0.6, 0.18, 0]],
    ['belly', [0, -0.22, 0]],
    ...LEGS.map(([name, x, z]) => [`${name} foot`, [x, -1.1, z]]),
    ...LEGS.map(([name, x, z]) => [`${name} knee`, [x + 0.05, -0.55, z]]),
  ],
};

function bonesOf(kind) {
  const foot = kind === 'camel' ? -1.08 : -0.93;
  const legs = LEGS.flatMap(([name, x, z]) => [
    [name, [x, -0.1, z], [x, foot / 2, z * 0.9], 0.085],
    [name, [x, foot / 2, z * 0.9], [x, foot, z * 0.9], 0.05],
  ]);
  return [...BONES[kind], ...legs];
}

function toBone(p, [, a, b, radius]) {
  const d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
  const w = [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
  const t = Math.min(Math.max((w[0] * d[0] + w[1] * d[1] + w[2] * d[2]) / (d[0] ** 2 + d[1] ** 2 + d[2] ** 2), 0), 1);
  return Math.hypot(w[0] - t * d[0], w[1] - t * d[1], w[2] - t * d[2]) - radius;
}

/** A smooth union: near joints the surfaces run into each other. */
function distance(p, bones) {
  const k = 0.06;
  let sum = 0;
  for (const bone of bones) sum += Math.exp(-toBone(p, bone) / k);
  return -k * Math.log(sum + 1e-12);
}

export function animal(kind, resolution) {
  const bones = bonesOf(kind);
  const low = [-1.05, kind === 'camel' ? -1.22 : -1.07, -0.4];
  const high = [1.4, 0.85, 0.4];
  const step = 2.45 / resolution;
  const size = low.map((l, i) => Math.ceil((high[i] - l) / step) + 1);
  const at = (x, y, z) => x + size[0] * (y + size[1] * z);
  const field = new Float32Array(size[0] * size[1] * size[2]);
  for (let z = 0; z < size[2]; z++)
    for (let y = 0; y < size[1]; y++)
      for (let x = 0; x < size[0]; x++)
        field[at(x, y, z)] = distance([low[0] + x * step, low[1] + y * step, low[2] + z * step], bones);
  const vertexOf = new Int32Array(field.length).fill(-1);
  const positions = [];
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => [i & 1, (i >> 1) & 1, (i >> 2) & 1]);
  for (let z = 0; z + 1 < size[2]; z++)
    for (let y = 0; y + 1 < size[1]; y++)
      for (let x = 0; x + 1 < size[0]; x++) {
        let count = 0;
        const sum = [0, 0, 0];
        for (let a = 0; a < 8; a++)
          for (let b = a + 1; b < 8; b++) {
            const bits = a ^ b;
            if (bits & (bits - 1)) continue;
            const fa = field[at(x + corners[a][0], y + corners[a][1], z + corners[a][2])];
            const fb = field[at(x + corners[b][0], y + corners[b][1], z + corners[b][2])];
            if (fa < 0 === fb < 0) continue;
            const t = fa / (fa - fb);
            for (let i = 0; i < 3; i++) sum[i] += corners[a][i] + t * (corners[b][i] - corners[a][i]);
            count++;
          }
        if (!count) continue;
        vertexOf[at(x, y, z)] = positions.length / 3;
        positions.push(
          low[0] + (x + sum[0] / count) * step,
          low[1] + (y + sum[1] / count) * step,
          low[2] + (z + sum[2] / count) * step,
        );
      }
  const quads = [];
  const offsets = [
    [1, at(1, 0, 0)],
    [2, at(0, 1, 0)],
    [3, at(0, 0, 1)],
  ].map(([, o]) => o);
  for (let z = 1; z + 1 < size[2]; z++)
    for (let y = 1; y + 1 < size[1]; y++)
      for (let x = 1; x + 1 < size[0]; x++) {
        const here = at(x, y, z);
        for (let axis = 0; axis < 3; axis++) {
          const inside = field[here] < 0;
          if (inside === field[here + offsets[axis]] < 0) continue;
          const [u, v] = [offsets[(axis + 1) % 3], offsets[(axis + 2) % 3]];
          const quad = [vertexOf[here], vertexOf[here - u], vertexOf[here - u - v], vertexOf[here - v]];
          quads.push(inside ? quad : quad.reverse());
        }
      }
  const components = [{ name: 'body', polygons: quads }];
  const eye = kind === 'camel' ? [1.06, 0.57] : [0.88, 0.52];
  for (const [name, z] of [
    ['eye_L', 0.1],
    ['eye_R', -0.1],
  ])
    components.push({ name, polygons: sphere(positions, [eye[0], eye[1], z], 0.035, 12) });
  return assemble(positions, components, bones);
}

function sphere(positions, centre, radius, count) {
  const first = positions.length / 3;
  for (let i = 0; i <= count; i++)
    for (let j = 0; j < count; j++) {
      const [a, b] = [(Math.PI * i) / count, (2 * Math.PI * j) / count];
      positions.push(
        centre[0] + radius * Math.sin(a) * Math.cos(b),
        centre[1] + radius * Math.cos(a),
        centre[2] - radius * Math.sin(a) * Math.sin(b),
      );
    }
  const polygons = [];
  for (let i = 0; i < count; i++)
    for (let j = 0; j < count; j++) {
      const k = (j + 1) % count;
      polygons.push([i * count + j, (i + 1) * count + j, (i + 1) * count + k, i * count + k].map((v) => v + first));
    }
  return polygons;
}

function assemble(list, parts, bones) {
  const positions = new Float32Array(list);
  const triangles = [];
  const components = [];
  const edges = new Set();
  const facts = [];
  parts.forEach((part, index) => {
    const before = components.length;
    for (const polygon of part.polygons) {
      for (let i = 0; i < polygon.length; i++) {
        const [a, b] = [polygon[i], polygon[(i + 1) % polygon.length]];
        edges.add(Math.min(a, b) * 2 ** 26 + Math.max(a, b));
      }
      for (let i = 2; i < polygon.length; i++) {
        triangles.push(polygon[0], polygon[i - 1], polygon[i]);
        components.push(index);
      }
    }
    facts.push({
      name: part.name,
      vertices: new Set(part.polygons.flat()).size,
      triangles: components.length - before,
    });
  });
  return {
    positions,
    triangles: new Uint32Array(triangles),
    components: new Uint32Array(components),
    welded: weld(positions),
    edges: new Uint32Array([...edges].flatMap((key) => [Math.floor(key / 2 ** 26), key % 2 ** 26])),
    facts,
    polygons: parts.reduce((sum, part) => sum + part.polygons.length, 0),
    weights: legWeights(positions, bones),
  };
}

function weld(positions) {
  const first = new Map();
  return new Uint32Array(positions.length / 3).map((_, v) => {
    const key = positions
      .subarray(v * 3, v * 3 + 3)
      .map((x) => Math.round(x * 1e6))
      .join();
    if (!first.has(key)) first.set(key, v);
    return first.get(key);
  });
}

function legWeights(positions, bones) {
  const legs = bones.filter(([name]) => /^(front|back)/.test(name));
  const rest = bones.filter(([name]) => !/^(front|back)/.test(name));
  return LEGS.map(([name]) => {
    const own = legs.filter((bone) => bone[0] === name);
    const others = legs.filter((bone) => bone[0] !== name);
    const weights = new Float32Array(positions.length / 3);
    for (let v = 0; v < weights.length; v++) {
      const p = positions.subarray(v * 3, v * 3 + 3);
      const near = (list) => Math.min(...list.map((bone) => Math.max(toBone(p, bone) + 0.05, 0.004)));
      const [a, b] = [near(own) ** -2, near(others) ** -2 + near(rest) ** -2];
      weights[v] = a / (a + b);
    }
    return weights;
  });
}

/** The positions at a phase of the walk, from 0 to 1, with strides of a strength. */
export function walk(mesh, phase, strength) {
  const result = mesh.positions.slice();
  const angles = [0, 0.5, 0.75, 0.25].map((lead) => strength * 0.5 * Math.sin(2 * Math.PI * (phase + lead)));
  for (let v = 0; v < result.length / 3; v++) {
    const [x, y] = [mesh.positions[v * 3], mesh.positions[v * 3 + 1]];
    for (let leg = 0; leg < 4; leg++) {
      const weight = mesh.weights[leg][v];
      if (weight < 0.01) continue;
      const [c, s] = [Math.cos(angles[leg]), Math.sin(angles[leg])];
      const [dx, dy] = [x - LEGS[leg][1], y + 0.05];
      result[v * 3] += weight * (c * dx - s * dy - dx);
      result[v * 3 + 1] += weight * (s * dx + c * dy - dy);
    }
    result[v * 3 + 1] += strength * 0.03 * Math.sin(4 * Math.PI * phase);
  }
  return result;
}

export function nearestVertex(positions, point) {
  let best = 0;
  let least = Infinity;
  for (let v = 0; v < positions.length / 3; v++) {
    const d =
      (positions[v * 3] - point[0]) ** 2 +
      (positions[v * 3 + 1] - point[1]) ** 2 +
      (positions[v * 3 + 2] - point[2]) ** 2;
    if (d < least) [least, best] = [d, v];
  }
  return best;
}
