import { api } from '../protocol/client.ts';
import { floats, words } from '../protocol/container.ts';
import type { Session, Side } from '../protocol/types.ts';
import { notify } from '../ui/notices.ts';
import type { MeshData } from '../viewer/surface.ts';

export interface Meshes {
  source: MeshData;
  target: MeshData;
}

export function sameMeshes(a: Session, b: Session): boolean {
  const of = ({ source, target }: Session) => JSON.stringify([source, target]);
  return of(a) === of(b);
}

/** Warns of files that are hardly meant so. */
export function warnOfFiles({ source, target, poses }: Session): void {
  if (source?.file && source.file === target?.file)
    notify('Source and target are the same file.', 'If that is a mistake, open another target.', 'error', 'files');
  else if (!poses || poses.list.length === 0)
    notify(
      'The source has no poses, so there is no motion to carry over.',
      'If the other mesh is the one that moves, open the files the other way round.',
      'error',
      'files',
    );
}

export async function loadMesh(side: Side): Promise<MeshData> {
  const { arrays } = await api.mesh(side);
  return {
    positions: floats(arrays, 'positions'),
    triangles: words(arrays, 'triangles'),
    components: words(arrays, 'components'),
    welded: words(arrays, 'welded'),
    edges: words(arrays, 'edges'),
  };
}
