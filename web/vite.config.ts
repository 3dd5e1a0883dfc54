import { defineConfig } from 'vite';
import { licences } from './build/licences.ts';

export default defineConfig({
  // The server may serve the page below any path.
  base: './',
  plugins: [licences()],
  build: {
    target: 'es2023',
    // Inlined files would be data: URLs, which the content security policy of the page refuses for fonts and scripts.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 900,
  },
});
