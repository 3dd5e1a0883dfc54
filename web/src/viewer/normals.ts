/**
 * Normals of vertices, weighted by area. `representative` names for each vertex the one whose place it shares, so that copies along
 * a seam of the texture get one normal and the seam does not show.
 */
export function computeNormals(
  positions: Float32Array,
  triangles: Uint32Array,
  representative: Uint32Array,
  normals: Float32Array,
): void {
  normals.fill(0);
  for (let t = 0; t < triangles.length; t += 3) {
    const a = triangles[t] * 3;
    const b = triangles[t + 1] * 3;
    const c = triangles[t + 2] * 3;
    const ux = positions[b] - positions[a];
    const uy = positions[b + 1] - positions[a + 1];
    const uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a];
    const vy = positions[c + 1] - positions[a + 1];
    const vz = positions[c + 2] - positions[a + 2];
    const nx = uy * vz - uz * vy;
    const ny = uz * vx - ux * vz;
    const nz = ux * vy - uy * vx;
    for (let corner = 0; corner < 3; corner++) {
      const i = representative[triangles[t + corner]] * 3;
      normals[i] += nx;
      normals[i + 1] += ny;
      normals[i + 2] += nz;
    }
  }
  // Lengths do not matter: the shader normalises what it interpolates. Copies only take over the sum.
  for (let v = 0; v < representative.length; v++) {
    const from = representative[v] * 3;
    if (from === v * 3) continue;
    normals[v * 3] = normals[from];
    normals[v * 3 + 1] = normals[from + 1];
    normals[v * 3 + 2] = normals[from + 2];
  }
  rescale(normals);
}

/** Brings the sums into a range that 16 bits of the graphics card hold, whatever the unit of the mesh. */
function rescale(normals: Float32Array): void {
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.hypot(normals[i], normals[i + 1], normals[i + 2]);
    if (length > 0) {
      normals[i] /= length;
      normals[i + 1] /= length;
      normals[i + 2] /= length;
    }
  }
}

const UNUSED = 0xffffffff;

/** For each vertex the first one with the same welded number; a vertex that no face uses stands for itself. */
export function representatives(welded: Uint32Array): Uint32Array {
  let highest = 0;
  for (const number of welded) if (number !== UNUSED && number > highest) highest = number;
  const first = new Uint32Array(highest + 1).fill(UNUSED);
  const result = new Uint32Array(welded.length);
  for (let v = 0; v < welded.length; v++) {
    const number = welded[v];
    if (number === UNUSED) {
      result[v] = v;
      continue;
    }
    if (first[number] === UNUSED) first[number] = v;
    result[v] = first[number];
  }
  return result;
}
