// SPDX-License-Identifier: Apache-2.0
// node validate.mjs MODULES [--animated] FILE...: runs the glTF-Validator (MODULES/node_modules) on .glb and .gltf files.
// Prints each error and warning; the exit code is 1 if there is an error, or with --animated if a file has no animation.
// Version 2.0.0-dev.3.10 does not know the names of the attributes of KHR_gaussian_splatting: this error is counted, and
// only for names of that extension.
import fs from 'node:fs';
import path from 'node:path';
import { createRequire } from 'node:module';

const [modules, ...words] = process.argv.slice(2);
const animated = words[0] === '--animated';
const files = animated ? words.slice(1) : words;
const validator = createRequire(path.join(path.resolve(modules), 'package.json'))('gltf-validator');
let failed = files.length === 0;
for (const file of files) {
  const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
    uri: file,
    maxIssues: 0,
    externalResourceFunction: async (uri) =>
        new Uint8Array(fs.readFileSync(path.join(path.dirname(file), decodeURIComponent(uri)))),
  });
  let unknown = 0;
  const messages = report.issues.messages.filter((issue) => {
    const attribute = issue.code === 'MESH_PRIMITIVE_INVALID_ATTRIBUTE' &&
        /\/attributes\/KHR_gaussian_splatting:(ROTATION|SCALE|OPACITY|SH_DEGREE_[0-3]_COEF_[0-6])$/.test(issue.pointer);
    if (attribute) ++unknown;
    return !attribute && issue.severity < 2;
  });
  for (const issue of messages) console.log(`${file}: ${issue.code} ${issue.pointer}: ${issue.message}`);
  const errors = messages.filter((issue) => issue.severity === 0).length;
  console.log(`${path.basename(file)}: ${errors} errors, ${messages.length - errors} warnings; ` +
              `${unknown} attributes of KHR_gaussian_splatting, ${report.info?.totalVertexCount ?? 0} vertices, ` +
              `${report.info?.animationCount ?? 0} animations`);
  // A report without vertices has not read the splats.
  if (errors > 0 || !(report.info?.totalVertexCount > 0) || (animated && !(report.info.animationCount > 0))) failed = true;
}
process.exit(failed ? 1 : 0);
