import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import type { Plugin } from 'vite';

export interface Licence {
  name: string;
  version: string;
  licence: string;
  text: string;
}

/** Writes `licences.json`: the licence of every npm package of which a module is in the bundle. */
export function licences(): Plugin {
  return {
    name: 'licences',
    apply: 'build',
    generateBundle(_options, bundle) {
      const modules = Object.values(bundle).flatMap((chunk) => (chunk.type === 'chunk' ? chunk.moduleIds : []));
      const found = foundLicences(modules);
      this.emitFile({ type: 'asset', fileName: 'licences.json', source: JSON.stringify(found, null, 1) });
    },
  };
}

/** The licences of the packages that modules are from. */
export function foundLicences(modules: readonly string[]): Licence[] {
  const folders = new Set(modules.map(packageFolder).filter((folder) => folder !== null));
  return [...folders].map(readLicence).sort((a, b) => a.name.localeCompare(b.name));
}

function packageFolder(moduleId: string): string | null {
  const path = moduleId.replace(/^\0/, '').split('?')[0] ?? '';
  const start = path.lastIndexOf('node_modules/');
  if (start < 0) return null;
  let folder = dirname(path);
  while (folder.length > start) {
    // Some packages have a bare package.json in folders below, which names no package.
    const manifest = join(folder, 'package.json');
    if (existsSync(manifest) && JSON.parse(readFileSync(manifest, 'utf8')).name) return folder;
    folder = dirname(folder);
  }
  return null;
}

function readLicence(folder: string): Licence {
  const manifest = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'));
  const file = readdirSync(folder).find((name) => /^licen[cs]e/i.test(name));
  if (!file) throw new Error(`${manifest.name} has no licence text, which the page must show`);
  return {
    name: manifest.name,
    version: manifest.version,
    licence: manifest.license,
    text: readFileSync(join(folder, file), 'utf8'),
  };
}
