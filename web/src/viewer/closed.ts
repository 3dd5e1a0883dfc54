/**
 * Whether a mesh is closed and shows its outside everywhere, so that the backs of its triangles are never seen and need not be drawn.
 * `components` names the component of each triangle, each of which must hold a volume of its own.
 */
export function isSolid(
  positions: Float32Array,
  triangles: Uint32Array,
  components: Uint32Array,
  representative: Uint32Array,
): boolean {
  return (
    edgesCancel(triangles, representative) && volumesOf(positions, triangles, components).every((volume) => volume >= 0)
  );
}

/** In a closed mesh each edge is passed once in each direction, so random numbers of edges with the sign of the direction sum to 0. */
function edgesCancel(triangles: Uint32Array, representative: Uint32Array): boolean {
  let [first, second] = [0, 0];
  for (let t = 0; t < triangles.length; t += 3) {
    for (let corner = 0; corner < 3; corner++) {
      const a = representative[triangles[t + corner]];
      const b = representative[triangles[t + ((corner + 1) % 3)]];
      if (a === b) continue;
      const [low, high, sign] = a < b ? [a, b, 1] : [b, a, -1];
      first = (first + sign * scatter(Math.imul(low, 0x9e3779b1) ^ scatter(high))) | 0;
      second = (second + sign * scatter(Math.imul(high, 0x85ebca6b) ^ scatter(low + 0x51ed27))) | 0;
    }
  }
  return first === 0 && second === 0;
}

function scatter(value: number): number {
  const mixed = Math.imul(value ^ (value >>> 16), 0x7feb352d);
  const more = Math.imul(mixed ^ (mixed >>> 15), 0x846ca68b);
  return more ^ (more >>> 16);
}

function volumesOf(positions: Float32Array, triangles: Uint32Array, components: Uint32Array): Float64Array {
  let count = 0;
  for (const component of components) if (component >= count) count = component + 1;
  const volumes = new Float64Array(count);
  for (let t = 0; t < components.length; t++) {
    const [a, b, c] = [triangles[t * 3] * 3, triangles[t * 3 + 1] * 3, triangles[t * 3 + 2] * 3];
    const crossX = positions[b + 1] * positions[c + 2] - positions[b + 2] * positions[c + 1];
    const crossY = positions[b + 2] * positions[c] - positions[b] * positions[c + 2];
    const crossZ = positions[b] * positions[c + 1] - positions[b + 1] * positions[c];
    volumes[components[t]] += positions[a] * crossX + positions[a + 1] * crossY + positions[a + 2] * crossZ;
  }
  return volumes;
}
