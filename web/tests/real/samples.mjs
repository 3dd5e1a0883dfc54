// Animals that the program makes: a horse that walks, and a camel that stands.
import { mkdir, readFile, rm, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { command } from './program.mjs';

/** Writes `horse.glb` and `camel.obj`; the numbers say how fine they are, and 60 gives 7,000 vertices. */
export async function makeAnimals(folder, { horse, camel }) {
  await mkdir(folder, { recursive: true });
  await makeGlb(folder, 'horse', horse);
  await makeGlb(folder, 'camel', camel);
  await writeFile(join(folder, 'camel.obj'), restAsObj(await readFile(join(folder, 'camel.glb'))));
  await rm(join(folder, 'camel.glb'));
}

/** An animal that takes its own walk has that walk in its file. */
async function makeGlb(folder, name, resolution) {
  const animal = JSON.stringify({ generator: { type: 'quadruped', proportions: name, gait: 'walk', resolution } });
  const pipeline = [
    `source: ${animal}`,
    `target: ${animal}`,
    'correspondence: { type: identity }',
    'transfer: { type: copy_displacement }',
    `output: ${name}.glb`,
  ];
  await writeFile(join(folder, 'make.yaml'), pipeline.join('\n'));
  await command(folder, 'run', 'make.yaml');
  await Promise.all(['make.yaml', 'run.json'].map((file) => rm(join(folder, file))));
}

/** The mesh at rest of a GLB with one mesh, without its poses. */
function restAsObj(glb) {
  const length = glb.readUInt32LE(12);
  const document = JSON.parse(glb.subarray(20, 20 + length).toString());
  const body = glb.subarray(28 + length);
  const [{ attributes, indices }] = document.meshes[0].primitives;
  const numbers = (index, Kind, width) => {
    const { bufferView, byteOffset = 0, count } = document.accessors[index];
    const start = (document.bufferViews[bufferView].byteOffset ?? 0) + byteOffset;
    return new Kind(new Uint8Array(body.subarray(start, start + count * width * Kind.BYTES_PER_ELEMENT)).buffer);
  };
  const places = numbers(attributes.POSITION, Float32Array, 3);
  const Index = document.accessors[indices].componentType === 5125 ? Uint32Array : Uint16Array;
  const corners = numbers(indices, Index, 1).map((corner) => corner + 1);
  return [...rows('v', places), ...rows('f', corners), ''].join('\n');
}

function rows(word, numbers) {
  return Array.from({ length: numbers.length / 3 }, (_, i) => `${word} ${numbers.slice(3 * i, 3 * i + 3).join(' ')}`);
}
