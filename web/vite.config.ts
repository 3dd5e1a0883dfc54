import { defineConfig } from 'vite';
import { licences } from './build/licences.ts';
import { notices } from './build/notices.ts';

/** The page of the studio. */
const studio = defineConfig({
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

/** The script that stands in a report, which needs no other file. */
const report = defineConfig({
  publicDir: false,
  plugins: [notices()],
  build: {
    target: 'es2023',
    outDir: 'dist/report',
    modulePreload: false,
    chunkSizeWarningLimit: 900,
    rolldownOptions: {
      input: 'src/report/main.ts',
      output: { format: 'iife', entryFileNames: 'viewer.js' },
    },
  },
});

export default defineConfig(({ mode }) => (mode === 'report' ? report : studio));
