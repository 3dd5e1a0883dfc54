/**
 * A coarse stand-in for a mesh: its vertices are gathered in the cells of a grid over the rest, and triangles of three different cells
 * are kept, with the first vertex of each cell. It uses the positions of the full mesh, so it follows every pose at no cost.
 */
export function coarseTriangles(positions: Float32Array, triangles: Uint32Array, cells: number): Uint32Array {
  const cellOf = assignCells(positions, cells);
  const first = new Map<number, number>();
  const result: number[] = [];
  const seen = new Set<number>();
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [cellOf[triangles[t]], cellOf[triangles[t + 1]], cellOf[triangles[t + 2]]];
    if (a === b || b === c || a === c) continue;
    // Several triangles may join the same cells; one is enough, and its direction does not matter for surfaces seen from both sides.
    const key = keyOf(a, b, c);
    if (seen.has(key)) continue;
    seen.add(key);
    for (let corner = 0; corner < 3; corner++) {
      const vertex = triangles[t + corner];
      const cell = cellOf[vertex];
      if (!first.has(cell)) first.set(cell, vertex);
      result.push(first.get(cell) ?? vertex);
    }
  }
  return new Uint32Array(result);
}

/** Numbers of cells in the order of their first vertex, so that they are small. */
function assignCells(positions: Float32Array, cells: number): Uint32Array {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; i++) {
    low[i % 3] = Math.min(low[i % 3], positions[i]);
    high[i % 3] = Math.max(high[i % 3], positions[i]);
  }
  const size = Math.max(...high.map((value, i) => value - low[i])) / cells || 1;
  const numbers = new Map<number, number>();
  const result = new Uint32Array(positions.length / 3);
  for (let v = 0; v < result.length; v++) {
    let place = 0;
    for (let axis = 0; axis < 3; axis++)
      place = place * 4096 + Math.floor((positions[v * 3 + axis] - low[axis]) / size);
    let number = numbers.get(place);
    if (number === undefined) {
      number = numbers.size;
      numbers.set(place, number);
    }
    result[v] = number;
  }
  return result;
}

/** One number for three cells in any order; with up to 2^17 cells it is exact. */
function keyOf(a: number, b: number, c: number): number {
  const low = Math.min(a, b, c);
  const high = Math.max(a, b, c);
  const middle = a + b + c - low - high;
  return (low * 2 ** 17 + middle) * 2 ** 17 + high;
}
