// Makes the page that the command fills with data: one HTML file, without a request to anywhere.
//   node bundle.js FOLDER OUT.html    FOLDER holds node_modules
// The page's policy allows the one script and the one style sheet that are in it, by their hashes, and nothing from elsewhere.
import { createHash } from 'node:crypto';
import { readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const [modules, out] = process.argv.slice(2);
const require = createRequire(join(modules, 'package.json'));
const esbuild = require('esbuild');

const options = { bundle: true, minify: true, write: false, legalComments: 'none', nodePaths: [join(modules, 'node_modules')], logLevel: 'warning' };
const script = esbuild.buildSync({ ...options, entryPoints: [join(here, 'main.js')], format: 'iife', target: 'es2020' }).outputFiles[0].text.replaceAll('</script', '<\\/script');
const style = esbuild.buildSync({ ...options, entryPoints: [join(here, 'style.css')] }).outputFiles[0].text;
const hash = (text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`;
const licence = readFileSync(join(modules, 'node_modules/three/LICENSE'), 'utf8');

const parts = {
  POLICY: `default-src 'none'; script-src ${hash(script)}; style-src ${hash(style)}; img-src data: blob:; base-uri 'none'; form-action 'none'`,
  LICENCE: `three.js\n\n${licence}`.replaceAll('--', '- -'),
  STYLE: style,
  SCRIPT: script,
};
writeFileSync(out, readFileSync(join(here, 'page.html'), 'utf8').replace(/@(POLICY|LICENCE|STYLE|SCRIPT)@/g, (_, name) => parts[name]));
