import type { Plugin } from 'vite';
import { foundLicences } from './licences.ts';

/** Puts the licences of packages at the head of a script that stands alone. */
export function notices(): Plugin {
  return {
    name: 'notices',
    apply: 'build',
    generateBundle(_options, bundle) {
      for (const chunk of Object.values(bundle)) {
        if (chunk.type !== 'chunk') continue;
        const texts = foundLicences(chunk.moduleIds).map(({ name, version, text }) => `${name} ${version}\n\n${text}`);
        chunk.code = `/*!\n${texts.join('\n\n').replaceAll('*/', '* /')}\n*/\n${chunk.code}`;
      }
    },
  };
}
