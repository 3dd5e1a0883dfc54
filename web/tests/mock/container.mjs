export function writeContainer(header, arrays) {
  const infos = Object.entries(arrays).map(([name, array]) => ({
    name,
    type: array instanceof Uint32Array ? 'u32' : 'f32',
    length: array.length,
  }));
  let json = JSON.stringify({ ...header, arrays: infos });
  json += ' '.repeat((4 - (Buffer.byteLength(json) % 4)) % 4);
  const head = Buffer.alloc(8);
  head.write('MSB1');
  head.writeUInt32LE(Buffer.byteLength(json), 4);
  return Buffer.concat([
    head,
    Buffer.from(json),
    ...Object.values(arrays).map((a) => Buffer.from(a.buffer, a.byteOffset, a.byteLength)),
  ]);
}
