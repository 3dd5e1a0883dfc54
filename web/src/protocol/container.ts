/** The layout of all binary data: `MSB1`, the length of a JSON header, the header, then arrays of four-byte numbers. */

export type Arrays = Record<string, Float32Array | Uint32Array>;

export interface Container<H> {
  header: H;
  arrays: Arrays;
}

interface ArrayInfo {
  name: string;
  type: 'f32' | 'u32';
  length: number;
}

const MAGIC = 0x3142534d;
const START = 8;

export function readContainer<H>(buffer: ArrayBuffer): Container<H> {
  if (buffer.byteLength < START) throw new Error('binary data is cut off');
  const view = new DataView(buffer);
  if (view.getUint32(0, true) !== MAGIC) throw new Error('binary data is of another kind');
  const headerLength = view.getUint32(4, true);
  if (headerLength % 4 !== 0 || START + headerLength > buffer.byteLength) throw new Error('binary data is cut off');
  const text = new TextDecoder().decode(new Uint8Array(buffer, START, headerLength));
  const header = JSON.parse(text) as H & { arrays: ArrayInfo[] };
  const arrays: Arrays = {};
  let offset = START + headerLength;
  for (const { name, type, length } of header.arrays) {
    if (!(length >= 0) || offset + length * 4 > buffer.byteLength) throw new Error(`the array ${name} is cut off`);
    arrays[name] = type === 'u32' ? new Uint32Array(buffer, offset, length) : new Float32Array(buffer, offset, length);
    offset += length * 4;
  }
  return { header, arrays };
}

export function writeContainer(header: object, arrays: Arrays): ArrayBuffer {
  const infos = Object.entries(arrays).map(([name, array]) => ({
    name,
    type: array instanceof Uint32Array ? 'u32' : 'f32',
    length: array.length,
  }));
  const json = JSON.stringify({ ...header, arrays: infos });
  const plain = new TextEncoder().encode(json);
  const headerLength = Math.ceil(plain.length / 4) * 4;
  const size = Object.values(arrays).reduce((sum, array) => sum + array.byteLength, START + headerLength);
  const buffer = new ArrayBuffer(size);
  const view = new DataView(buffer);
  view.setUint32(0, MAGIC, true);
  view.setUint32(4, headerLength, true);
  const bytes = new Uint8Array(buffer);
  bytes.fill(0x20, START, START + headerLength);
  bytes.set(plain, START);
  let offset = START + headerLength;
  for (const array of Object.values(arrays)) {
    bytes.set(new Uint8Array(array.buffer, array.byteOffset, array.byteLength), offset);
    offset += array.byteLength;
  }
  return buffer;
}

export function floats(arrays: Arrays, name: string): Float32Array {
  const array = arrays[name];
  if (!(array instanceof Float32Array)) throw new Error(`binary data lacks the array ${name}`);
  return array;
}

export function words(arrays: Arrays, name: string): Uint32Array {
  const array = arrays[name];
  if (!(array instanceof Uint32Array)) throw new Error(`binary data lacks the array ${name}`);
  return array;
}
