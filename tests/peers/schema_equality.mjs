// Our schemas mean what the published ones mean, corrected: the same messages are valid.
//   schema_equality.mjs FLEETPUB RESULTS [REFERENCE [record]]
//
// With the published files (the folder REFERENCE), messages are made from our schemas and from theirs, and what `fleetpub
// validate` says of each is compared with ajv's word on theirs. Without them, what it says of those made from ours is compared
// with the recorded results (the file RESULTS), which `record` writes anew.
import { spawnSync } from "node:child_process";
import { createHash } from "node:crypto";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import Ajv from "ajv";
import Ajv2020 from "ajv/dist/2020.js";
import addFormats from "ajv-formats";
import { Generator, normalForm } from "./message_generator.mjs";
import { corrected } from "./published_schemas.mjs";

const COUNT = 1000;
const SEEDS = { ours: 5050, theirs: 3339 };
const OLD = ["connection", "instantActions", "order", "state", "visualization"];
const TOPICS = {
  "1.1.0": OLD,
  "2.0.0": [...OLD, "factsheet"],
  "2.1.0": [...OLD, "factsheet"],
  "3.0.0": [...OLD, "factsheet", "responses", "zoneSet"],
};

const [binary, resultsFile, reference, mode] = process.argv.slice(2);
const fleetpub = process.env.FLEETPUB_BINARY ?? binary;
const haveReference = reference !== undefined;
const recorded = existsSync(resultsFile) ? JSON.parse(readFileSync(resultsFile, "utf8")) : {};
const fresh = {};
const problems = [];

function run(args, input) {
  const environment = Object.fromEntries(Object.entries(process.env).filter(([name]) => !name.startsWith("FLEETPUB_")));
  const result = spawnSync(fleetpub, args, { input, encoding: "utf8", maxBuffer: 2 ** 30, env: environment });
  if (result.error) throw result.error;
  return result;
}

function ownSchema(version, topic) {
  const shown = run(["schema", "show", `vda5050/${version}/${topic}`]);
  if (shown.status !== 0) throw new Error(shown.stderr);
  return JSON.parse(shown.stdout);
}

const within = (root) => (reference, base) => {
  const names = reference.slice(2).split("/");
  return { schema: names.reduce((value, name) => value[name], root), base };
};

function ourResults(version, topic, messages) {
  const result = run(["validate", "--lines", "--vda", version, "--topic", topic, "-o", "json"], messages.join("\n"));
  const lines = result.stdout.trim().split("\n").map((line) => JSON.parse(line));
  if (lines.length !== messages.length) throw new Error(`${lines.length} results on ${messages.length} messages: ${result.stderr}`);
  return lines.map(({ valid }) => valid);
}

function compiled(published) {
  const ajv = new (published.dialect === "2020-12" ? Ajv2020 : Ajv)({ strict: false, logger: false });
  addFormats(ajv);
  published.others.forEach((schema) => ajv.addSchema(schema));
  return ajv.compile(published.schema);
}

// The places that no message breaks, by ajv's list of everything that is wrong with each.
function untouched(generator, messages) {
  const ajv = new Ajv({ strict: false, logger: false, allErrors: true });
  addFormats(ajv);
  const validate = ajv.compile(generator.schema);
  const left = new Set(generator.places.map(({ at }) => at));
  for (const message of messages) {
    if (validate(JSON.parse(message))) continue;
    for (const { schemaPath, params: { missingProperty: missing } } of validate.errors) {
      left.delete(missing === undefined ? decodeURIComponent(schemaPath) : `${schemaPath}/${missing}`);
    }
  }
  return [...left];
}

function compare(pair, messages, ours, theirs) {
  messages.forEach((message, i) => {
    if (ours[i] === theirs[i]) return;
    problems.push(`${pair}: we say ${ours[i] ? "valid" : "invalid"}, which is wrong: ${message.slice(0, 400)}`);
  });
  const valid = theirs.filter(Boolean).length;
  if (valid < messages.length / 10) problems.push(`${pair}: only ${valid} of ${messages.length} messages are valid`);
}

function makeMessages(pair, schema, seed) {
  const generator = new Generator(schema, seed);
  const messages = generator.messages(COUNT);
  for (const place of untouched(generator, messages)) problems.push(`${pair}: no message breaks ${place}`);
  return messages;
}

const bits = (results) => {
  const bytes = Buffer.alloc(Math.ceil(results.length / 8));
  results.forEach((result, i) => { if (result) bytes[i >> 3] |= 1 << (i & 7); });
  return bytes.toString("base64");
};
const fromBits = (text) => {
  const bytes = Buffer.from(text, "base64");
  return Array.from({ length: COUNT }, (_, i) => (bytes[i >> 3] & (1 << (i & 7))) !== 0);
};
const hash = (messages) => createHash("sha256").update(messages.join("\n")).digest("hex").slice(0, 16);

let checked = 0;
for (const [version, topics] of Object.entries(TOPICS)) {
  for (const topic of topics) {
    const pair = `${version}/${topic}`;
    const schema = ownSchema(version, topic);
    const messages = makeMessages(pair, normalForm(schema, within(schema), ""), SEEDS.ours);
    const ours = ourResults(version, topic, messages);
    checked += messages.length;
    if (!haveReference) {
      const known = recorded[pair];
      if (known?.messages === hash(messages)) compare(pair, messages, ours, fromBits(known.valid));
      else problems.push(`${pair}: means something else than when results were recorded: compare with the published files and record`);
      continue;
    }
    const published = corrected(reference, version, topic);
    const validate = compiled(published);
    const check = (message) => validate(JSON.parse(message));
    const theirs = messages.map(check);
    compare(pair, messages, ours, theirs);
    fresh[pair] = { messages: hash(messages), valid: bits(theirs) };
    const form = normalForm(published.schema, published.resolve, published.base);
    const others = makeMessages(`${pair} as published`, form, SEEDS.theirs);
    compare(pair, others, ourResults(version, topic, others), others.map(check));
    checked += others.length;
  }
}

// A line for each pair.
const listed = (results) => {
  const lines = Object.entries(results).map(([pair, each]) => `  ${JSON.stringify(pair)}: ${JSON.stringify(each)}`);
  return `{\n${lines.join(",\n")}\n}\n`;
};
if (haveReference && mode === "record" && problems.length === 0) writeFileSync(resultsFile, listed(fresh));
else if (haveReference && listed(fresh) !== listed(recorded)) problems.push(`${resultsFile} is out of date: run again with "record"`);

for (const problem of problems.slice(0, 20)) console.error(problem);
console.log(`${checked} messages checked beside ${haveReference ? "ajv on the published schemas" : "recorded results"}, ${problems.length} problems`);
process.exit(problems.length === 0 ? 0 : 1);
