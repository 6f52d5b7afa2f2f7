// SPDX-License-Identifier: Apache-2.0
// node check_manifests.mjs MODULES FOLDER [PROGRAMS]: validates the Kubernetes manifests of FOLDER, and what each of its
// kustomizations makes of them, with the packages in MODULES/node_modules. Kubernetes' own kinds and ServiceMonitor:
// kubernetes-models and @kubernetes-models/prometheus-operator; kinds of Agones: agones.schema.json here. Prints each
// error as "file: kind/name: field: problem"; the exit code is 1 if there is one. Of kustomize, the keys resources,
// namespace, images and patches (JSON 6902) are supported; another key is an error. With a folder of programs, each option of
// a container's args must be in the help of its program.
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { createRequire } from 'node:module';
import { fileURLToPath, pathToFileURL } from 'node:url';

const [modules, folder, programs] = process.argv.slice(2);
const packages = path.join(path.resolve(modules), 'node_modules');
const required = createRequire(path.join(path.resolve(modules), 'package.json'));
const yaml = required('yaml');
const Ajv = required('ajv').default;
const typeOf = async (name, type) =>
  (await import(pathToFileURL(path.join(packages, name, '_schemas', `${type}.js`)))).validate;
const kubernetes = (type) => typeOf('kubernetes-models', type);

// Type of each kind. A kind without an entry is an error.
const kinds = {
  'v1 ConfigMap': await kubernetes('IoK8sApiCoreV1ConfigMap'),
  'v1 Service': await kubernetes('IoK8sApiCoreV1Service'),
  'batch/v1 Job': await kubernetes('IoK8sApiBatchV1Job'),
  'policy/v1 PodDisruptionBudget': await kubernetes('IoK8sApiPolicyV1PodDisruptionBudget'),
  'networking.k8s.io/v1 NetworkPolicy': await kubernetes('IoK8sApiNetworkingV1NetworkPolicy'),
  'monitoring.coreos.com/v1 ServiceMonitor': await typeOf(
    '@kubernetes-models/prometheus-operator',
    'ComGithubPrometheusOperatorPrometheusOperatorPkgApisMonitoringV1ServiceMonitor'),
};

// The validators of kubernetes-models ignore fields that a type does not have. They read each field that it has, so a
// field that was not read is unknown. An object of which no field was read is of free form.
function watched(value, at, unknown) {
  if (value === null || typeof value !== 'object') return value;
  const read = new Set();
  const inner = Object.fromEntries(Object.keys(value).map((key) => [key, watched(value[key], `${at}/${key}`, unknown)]));
  const shown = Array.isArray(value) ? Object.values(inner) : inner;
  unknown.push(() =>
    read.size === 0 ? [] : Object.keys(value).filter((key) => !read.has(key)).map((key) => `${at}/${key}`));
  return new Proxy(shown, {
    get(target, key) {
      if (typeof key === 'string') read.add(key);
      return target[key];
    },
  });
}

// Errors of a value against a validator of kubernetes-models, as "field: problem".
function errorsOf(validate, value) {
  const unknown = [];
  const good = validate(watched(value, '', unknown));
  return [
    ...(good ? [] : validate.errors).map((error) => `${error.instancePath || '/'}: ${problemOf(error)}`),
    ...unknown.flatMap((list) => list()).map((field) => `${field}: unknown field`),
  ];
}
function problemOf({ keyword, params, message }) {
  return message ?? (keyword === 'required' ? `needs ${params.missingProperty}`
    : keyword === 'enum' ? `must be one of ${params.allowedValues.join(', ')}`
    : `${keyword} must be ${Object.values(params).join(' ')}`);
}

const podTypes = { IoK8sApiCoreV1PodTemplateSpec: await kubernetes('IoK8sApiCoreV1PodTemplateSpec') };
const ajv = new Ajv({ allErrors: true, strict: false });
ajv.addKeyword({
  keyword: 'kubernetesType',
  validate: function check(type, value) {
    check.errors = errorsOf(podTypes[type], value).map((text) => ({ keyword: 'kubernetesType', message: text }));
    return check.errors.length === 0;
  },
});
const agones = JSON.parse(fs.readFileSync(fileURLToPath(new URL('agones.schema.json', import.meta.url))));
ajv.addSchema(agones, 'agones');
for (const [kind, schema] of Object.entries(agones.kinds)) {
  const validate = ajv.compile(schema);
  kinds[kind] = Object.assign((value) => validate(value), { agones: validate });
}
function agonesErrors(validate, value) {
  if (validate(value)) return [];
  return validate.errors.map((error) => {
    if (error.keyword === 'kubernetesType') return `${error.instancePath}${error.message}`;
    const field = error.params?.additionalProperty;
    return field ? `${error.instancePath}/${field}: unknown field` : `${error.instancePath || '/'}: ${error.message}`;
  });
}

let failed = false;
let checked = 0;
function report(where, text) {
  console.log(`${where}: ${text}`);
  failed = true;
}
function check(where, object) {
  ++checked;
  const kind = `${object?.apiVersion} ${object?.kind}`;
  const name = `${object?.kind}/${object?.metadata?.name ?? '(generated)'}`;
  const validate = kinds[kind];
  if (!validate) return report(where, `${kind}: no schema for this kind; add one to check_manifests.mjs`);
  const errors = validate.agones ? agonesErrors(validate.agones, object) : errorsOf(validate, object);
  for (const error of errors) report(where, `${name}: ${error}`);
  if (programs) checkOptions(where, name, object);
}
// Without a command, a container runs the image's entry point, livegs-server. The first argument of livegs is its command.
const helps = new Map();
function checkOptions(where, name, object) {
  const pod = object.kind === 'Fleet' ? object.spec.template.spec.template.spec : object.kind === 'Job' && object.spec.template.spec;
  for (const { command = ['livegs-server'], args = [] } of pod ? pod.containers : []) {
    const words = [command[0], ...(command[0] === 'livegs' && !args[0].startsWith('-') ? [args[0]] : [])];
    const key = words.join(' ');
    if (!helps.has(key))
      helps.set(key, execFileSync(path.join(path.resolve(programs), words[0]), [...words.slice(1), '--help'], { encoding: 'utf8' }));
    for (const option of args.filter((word) => word.startsWith('--')).map((word) => word.split('=')[0])) {
      if (!helps.get(key).split(/[\s,]+/).includes(option)) report(where, `${name}: ${option}: ${key} has no such option`);
    }
  }
}

function documents(file) {
  const all = yaml.parseAllDocuments(fs.readFileSync(file, 'utf8'), { version: '1.1', uniqueKeys: true });
  for (const document of all) {
    for (const error of document.errors) report(file, error.message.split('\n')[0]);
  }
  return all.map((document) => document.toJS()).filter((object) => object !== null);
}

// A JSON 6902 patch: add, replace and remove.
function patch(object, operations, where) {
  for (const { op, path: at, value } of operations) {
    const keys = at.split('/').slice(1).map((key) => key.replaceAll('~1', '/').replaceAll('~0', '~'));
    const last = keys.pop();
    const into = keys.reduce((inner, key) => inner?.[key], object);
    if (into === undefined || into === null) { report(where, `${op} ${at}: no such place`); continue; }
    if (Array.isArray(into) && last === '-' && op === 'add') into.push(value);
    else if (op === 'add') into[last] = value;
    else if (!(last in into)) report(where, `${op} ${at}: no such field`);
    else if (op === 'replace') into[last] = value;
    else if (op === 'remove') delete into[last];
    else report(where, `${op}: unknown operation`);
  }
}

const known = ['apiVersion', 'kind', 'resources', 'namespace', 'images', 'patches'];
function build(directory) {
  const file = path.join(directory, 'kustomization.yaml');
  const [made] = documents(file);
  if (made.apiVersion !== 'kustomize.config.k8s.io/v1beta1' || made.kind !== 'Kustomization')
    report(file, 'apiVersion and kind: must be kustomize.config.k8s.io/v1beta1 and Kustomization');
  for (const key of Object.keys(made)) if (!known.includes(key)) report(file, `${key}: unknown field`);
  const objects = [];
  for (const resource of made.resources ?? []) {
    const at = path.join(directory, resource);
    if (!fs.existsSync(at)) report(file, `resources: ${resource}: no such file`);
    else if (fs.statSync(at).isDirectory()) objects.push(...build(at));
    else objects.push(...documents(at));
  }
  for (const object of objects) if (made.namespace) object.metadata.namespace = made.namespace;
  for (const { target, patch: text } of made.patches ?? []) {
    const to = objects.filter((object) =>
      object.kind === target.kind && (target.name === undefined || object.metadata.name === target.name));
    if (to.length === 0) report(file, `patches: ${target.kind}/${target.name}: no such object`);
    for (const object of to) patch(object, yaml.parse(text), file);
  }
  return objects;
}
// Folders of a kustomization and of those that it includes.
function folders(directory) {
  const included = (documents(path.join(directory, 'kustomization.yaml'))[0].resources ?? [])
    .map((resource) => path.join(directory, resource)).filter((at) => fs.statSync(at, { throwIfNoEntry: false })?.isDirectory());
  return [directory, ...included.flatMap(folders)];
}

const files = fs.readdirSync(folder, { recursive: true }).filter((name) => name.endsWith('.yaml')).sort();
for (const name of files) {
  const file = path.join(folder, name);
  if (path.basename(name) !== 'kustomization.yaml') for (const object of documents(file)) check(file, object);
  else for (const object of build(path.dirname(file))) check(file, object);
}
// Each manifest of a folder with a kustomization is one of its resources.
for (const name of files.filter((file) => path.basename(file) === 'kustomization.yaml')) {
  const directory = path.join(folder, path.dirname(name));
  const listed = documents(path.join(folder, name))[0].resources ?? [];
  for (const other of fs.readdirSync(directory)) {
    if (other.endsWith('.yaml') && other !== 'kustomization.yaml' && !listed.includes(other))
      report(path.join(folder, name), `resources: ${other} is missing`);
  }
}
// No two kustomizations make the same object, unless one includes the other: deleting one would take it from the other.
const makers = new Map();
for (const name of files.filter((file) => path.basename(file) === 'kustomization.yaml')) {
  const directory = path.join(folder, path.dirname(name));
  for (const { kind, metadata } of build(directory)) {
    const object = `${kind}/${metadata.name}`;
    const others = makers.get(object) ?? [];
    for (const other of others) {
      if (!folders(directory).includes(other) && !folders(other).includes(directory))
        report(path.join(folder, name), `${object}: ${path.relative(folder, other)} makes it too`);
    }
    makers.set(object, [...others, directory]);
  }
}
console.log(`${files.length} files, ${checked} objects checked`);
process.exit(failed || checked === 0 ? 1 : 0);
