/** The component of each triangle: triangles that share vertices are of one. */
export function componentsOf(triangles: Uint32Array, vertices: number): Uint32Array {
  const parent = Uint32Array.from({ length: vertices }, (_, v) => v);
  function root(v: number): number {
    let at = v;
    while (parent[at] !== at) {
      parent[at] = parent[parent[at]];
      at = parent[at];
    }
    return at;
  }
  for (let t = 0; t < triangles.length; t += 3) {
    for (let corner = 1; corner < 3; corner++) {
      const [a, b] = [root(triangles[t]), root(triangles[t + corner])];
      parent[Math.max(a, b)] = Math.min(a, b);
    }
  }
  const numbers = new Map<number, number>();
  return Uint32Array.from({ length: triangles.length / 3 }, (_, t) => {
    const first = root(triangles[t * 3]);
    const number = numbers.get(first) ?? numbers.size;
    numbers.set(first, number);
    return number;
  });
}

/** The edges of polygons, each once: those of triangles without the diagonals between triangles of one polygon. */
export function edgesOf(triangles: Uint32Array, continues: Uint8Array | null): Uint32Array {
  const edges = new Map<number, [number, number]>();
  const diagonals = new Set<number>();
  let before: number[] = [];
  for (let t = 0; t < triangles.length; t += 3) {
    const keys: number[] = [];
    for (let corner = 0; corner < 3; corner++) {
      const [a, b] = [triangles[t + corner], triangles[t + ((corner + 1) % 3)]];
      // Below 2^53 for the vertices that a report may hold.
      const key = Math.min(a, b) * 2 ** 26 + Math.max(a, b);
      keys.push(key);
      edges.set(key, [a, b]);
    }
    if (continues?.[t / 3]) for (const key of keys) if (before.includes(key)) diagonals.add(key);
    before = keys;
  }
  for (const key of diagonals) edges.delete(key);
  return Uint32Array.from([...edges.values()].flat());
}
