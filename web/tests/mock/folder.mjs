/** A folder of the mock, which has no files. */
export function folder(path) {
  const root = { name: 'meshes', path: '/meshes' };
  const file = (name, kind, bytes) => ({
    name,
    path: `${path ?? '/meshes'}/${name}`,
    kind,
    bytes,
    modified: 1700000000,
  });
  const entries =
    path === '/meshes/faces'
      ? []
      : [
          file('faces', 'folder', 0),
          file('broken.obj', 'mesh', 512),
          file('camel.glb', 'mesh', 812332),
          file('horse.glb', 'mesh', 1482332),
          file('horse-to-camel.yaml', 'pipeline', 420),
          file('notes.txt', 'other', 99),
        ];
  return {
    path: path ?? '/meshes',
    parent: path && path !== '/meshes' ? '/meshes' : null,
    roots: [root, { name: 'Uploads', path: '/uploads' }],
    entries,
  };
}
