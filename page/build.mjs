// Bundles the page into one file of HTML and writes it as a C++ source.
//   node build.mjs OUTPUT.cpp
import { createHash } from 'node:crypto';
import { readFileSync, writeFileSync } from 'node:fs';
import { build } from 'esbuild';

const GAP = '<!--contents-->'; // where the program puts the contents; kPageGap in host/report/page_text.h

async function bundle(entry, options) {
  const result = await build({ entryPoints: [entry], bundle: true, minify: true, write: false, legalComments: 'none', target: 'es2022', ...options });
  return result.outputFiles[0].text.trim();
}

// Script and style must not contain the tag that would end their element.
const script = (await bundle('src/main.ts', { format: 'iife' })).replaceAll('</script', '<\\/script');
const style = await bundle('src/page.css', { loader: { '.css': 'css' } });
const hashOf = (text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`;
// Only this script and this style may run, and the page loads nothing else.
const policy = `default-src 'none'; script-src ${hashOf(script)}; style-src ${hashOf(style)}; img-src data: blob:; base-uri 'none'; form-action 'none'`;
const page = readFileSync('src/page.html', 'utf8')
  .replace('<!--policy-->', () => policy)
  .replace('<!--style-->', () => style)
  .replace('<!--script-->', () => script);
if (page.split(GAP).length !== 2) throw new Error(`page/build.mjs: ${GAP} has to stand once in the page`);

const bytes = Buffer.from(page, 'utf8');
// A ? is escaped, too, for it could begin a trigraph of C++.
const literal = (part) =>
  `"${Array.from(part, (byte) =>
    byte === 34 || byte === 92 ? `\\${String.fromCharCode(byte)}` : byte < 32 || byte > 126 || byte === 63 ? `\\${byte.toString(8).padStart(3, '0')}` : String.fromCharCode(byte),
  ).join('')}"`;
const lines = [];
for (let at = 0; at < bytes.length; at += 4096) lines.push(literal(bytes.subarray(at, at + 4096)));
writeFileSync(
  process.argv[2],
  `// Made of page/ by build.mjs.
#include <string_view>

namespace viewpeel {

extern const std::string_view kPageText;
const std::string_view kPageText(
    ${lines.join('\n    ')},
    ${bytes.length});

}  // namespace viewpeel
`,
);
