// Makes messages from a JSON Schema: valid ones, and ones broken in one or several known places.
//
// What it makes depends on the seed and on what the schema means, not on how it is written: references are followed,
// annotations dropped and names sorted first. So messages stay the same when a schema is only arranged anew.

const ANNOTATIONS = new Set(["$schema", "$id", "$comment", "title", "description", "examples", "unit", "default",
  "definitions", "documentVersion", "subtopic"]);

// A schema without references. `resolve(reference, base)` gives {schema, base} of what a reference means.
export function normalForm(schema, resolve, base) {
  if ("$ref" in schema) {
    const target = resolve(schema.$ref, base);
    return normalForm(target.schema, resolve, target.base);
  }
  const form = {};
  const inner = (each) => normalForm(each, resolve, base);
  for (const [keyword, value] of Object.entries(schema)) {
    if (ANNOTATIONS.has(keyword)) continue;
    if (keyword === "properties") merge(form, { properties: mapValues(value, inner) });
    else if (["items", "if", "then"].includes(keyword)) form[keyword] = inner(value);
    else if (keyword === "allOf") value.map(inner).forEach((each) => "if" in each ? (form.allOf ??= []).push(each) : merge(form, each));
    else if (["required", "enum"].includes(keyword)) merge(form, { [keyword]: value });
    else if (keyword === "type") form.type = [value].flat().sort();
    else if (["const", "minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum", "minItems"].includes(keyword)) form[keyword] = value;
    else if (keyword === "format") { if (value === "date-time") form.format = value; }
    else throw new Error(`no messages can be made for ${keyword}`);
  }
  return sorted(form);
}

function merge(form, other) {
  for (const [keyword, value] of Object.entries(other)) {
    if (keyword === "properties") form.properties = { ...form.properties, ...value };
    else if (keyword === "required") form.required = [...(form.required ?? []), ...value];
    else form[keyword] = value;
  }
}

function sorted(form) {
  if (form.properties) form.properties = Object.fromEntries(Object.entries(form.properties).sort(([a], [b]) => (a < b ? -1 : 1)));
  form.required = [...new Set(form.required ?? [])].sort();
  if (!form.required.length) delete form.required;
  if (form.enum) form.enum = [...form.enum].sort();
  form.allOf?.sort((a, b) => (JSON.stringify(a.if) < JSON.stringify(b.if) ? -1 : 1));
  return Object.fromEntries(Object.entries(form).sort(([a], [b]) => (a < b ? -1 : 1)));
}

const mapValues = (object, f) => Object.fromEntries(Object.entries(object).map(([name, value]) => [name, f(value)]));

// Every place of the schema that a message can break: {steps, keyword, name, at}. `steps` lead there through the message:
// {member}, {item} or {branch} (of allOf); `at` is what ajv calls the place.
export function places(schema, steps = [], at = "#") {
  const found = [];
  for (const keyword of ["type", "enum", "format", "minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum", "minItems"]) {
    if (keyword in schema) found.push({ steps, keyword, at: `${at}/${keyword}` });
  }
  for (const name of schema.required ?? []) found.push({ steps, keyword: "required", name, at: `${at}/required/${name}` });
  for (const [name, each] of Object.entries(schema.properties ?? {})) {
    found.push(...places(each, [...steps, { member: name }], `${at}/properties/${name.replaceAll("~", "~0").replaceAll("/", "~1")}`));
  }
  if (schema.items) found.push(...places(schema.items, [...steps, { item: true }], `${at}/items`));
  schema.allOf?.forEach((each, branch) => found.push(...places(each.then, [...steps, { branch }], `${at}/allOf/${branch}/then`)));
  return found;
}

// A number as it is to stand in the text: 1.0, 1e2.
class Written { constructor(text) { this.text = text; } }

export function toText(value) {
  if (value instanceof Written) return value.text;
  if (Array.isArray(value)) return `[${value.map(toText).join()}]`;
  if (value === null || typeof value !== "object") return JSON.stringify(value);
  return `{${Object.entries(value).map(([name, each]) => `${JSON.stringify(name)}:${toText(each)}`).join()}}`;
}

const TEXTS = ["", "a", "KIT/0001", "0", "NONE", "map 1", "Größe 30 µm", "日本", "\u0000", "\"\\", "x".repeat(40), "2026-01-02T03:04:05Z"];
const DATES = ["2026-01-02T03:04:05.678Z", "2026-01-02T03:04:05Z", "2024-02-29T23:59:59.1Z", "2000-02-29T00:00:00Z",
  "2026-12-31T23:59:59.999999999+01:00", "2026-06-30T00:00:00-12:30", "2016-12-31T23:59:60Z", "2017-01-01T00:59:60+01:00",
  "2026-01-02t03:04:05z", "0001-01-01T00:00:00Z", "9999-12-31T23:59:59+23:59"];
// ajv takes some that RFC 3339 does not have: a blank in place of the T, `+01` and `+0100`, a leap second on any day. None of
// those here.
const NO_DATES = ["", "now", "2026-01-02", "03:04:05Z", "2026-01-02T03:04:05", "2023-02-29T00:00:00Z", "1900-02-29T00:00:00Z",
  "2026-04-31T00:00:00Z", "2026-13-01T00:00:00Z", "2026-00-01T00:00:00Z", "2026-01-00T00:00:00Z", "2026-01-02T24:00:00Z",
  "2026-01-02T03:60:00Z", "2026-01-02T03:04:60Z", "2026-01-02T03:04:61Z", "2026-1-2T3:4:5Z", "26-01-02T03:04:05Z",
  "2026-01-02T03:04:05.Z", "2026-01-02T03:04:05,5Z", "2026-01-02T03:04:05+24:00", "2026-01-02T03:04:05+01:60",
  " 2026-01-02T03:04:05Z", "2026-01-02T03:04:05Z ", "2026-01-02T03:04:05ZZ", "2026/01/02T03:04:05Z", "٢٠٢٦-01-02T03:04:05Z"];
const WHOLE = [0, 1, 2, 7, 100, -1, -7, 4294967295, 4294967296, 9007199254740991, new Written("1.0"), new Written("3e2"), new Written("-0")];
const FRACTIONS = [0.5, -0.5, 1.25, 99.9, 3.14159265358, -3.14159265358, 1e-7, -1e9, new Written("1e300"), new Written("2.50")];
const OTHERS = {  // by type
  null: [null], boolean: [true, false], string: ["", "1", "true", "x"], number: [0.5, -2.5], integer: [0, 1, 17, -1],
  array: [[], [1], ["ONLINE"], [{}]], object: [{}, { key: "a", value: 1 }],
};

const valueOf = (number) => (number instanceof Written ? Number(number.text) : number);

export class Generator {
  constructor(schema, seed) {
    this.schema = schema;
    this.places = places(schema);
    this.state = seed;
  }

  // `count` texts: every place broken by itself once, then a mixture.
  messages(count) {
    if (count < this.places.length * 1.2) throw new Error(`${count} messages are too few for ${this.places.length} places`);
    const texts = this.places.map((place) => this.broken([place]));
    while (texts.length < count) {
      const breaks = this.below(10) < 4 ? 0 : 1 + this.below(4);
      texts.push(this.broken(Array.from({ length: breaks }, () => this.pick(this.places))));
    }
    return texts;
  }

  broken(breaks) {
    this.share = this.pick([0, 0.3, 0.6, 1]);
    const holder = { message: this.make(this.schema, breaks[0]?.steps ?? []) };
    for (const place of breaks) {
      const reached = this.reach(holder, place.steps);
      if (reached.length) this.break(place, ...this.pick(reached));
    }
    return toText(holder.message);
  }

  // A valid value that has everything that `steps` lead through.
  make(schema, steps) {
    const [step, ...rest] = steps;
    if ("enum" in schema) return this.pick(schema.enum);
    if ("const" in schema) return schema.const;
    const type = this.pick(schema.type ?? ["object"]);
    if (type === "object") return this.object(schema, step, rest);
    if (type === "array") {
      const least = Math.max(schema.minItems ?? 0, step ? 1 : 0);
      const items = schema.items ?? { type: ["boolean", "number", "string"] };
      return Array.from({ length: least + this.below(3) }, (_, i) => this.make(items, i === 0 ? rest : []));
    }
    if (type === "string") return this.pick(schema.format ? DATES : TEXTS);
    if (type === "boolean") return this.below(2) === 1;
    return this.number(schema, type);
  }

  object(schema, step, rest) {
    const value = {};
    const fill = (part, member) => {
      for (const [name, each] of Object.entries(part.properties ?? {})) {
        const wanted = name === member || part.required?.includes(name) || this.chance(this.share);
        if (wanted && !(name in value)) value[name] = this.make(each, name === member ? rest : []);
      }
    };
    const branch = schema.allOf?.[step?.branch];
    if (branch) Object.assign(value, mapValues(branch.if.properties, (each) => each.const));
    fill(schema, step?.member);
    schema.allOf?.forEach((each) => {
      if (meets(each.if, value)) fill(each.then, each === branch ? rest[0]?.member : undefined);
    });
    if (branch && rest.length) value[rest[0].member] = this.make(branch.then.properties[rest[0].member], rest.slice(1));
    if (this.chance(0.05)) value[this.pick(["note", "x-site", "headerid", "actions ", "vendor.value"])] = this.pick([1, "a", null, [], {}]);
    return value;
  }

  number(schema, type) {
    const fits = (number) => {
      const value = valueOf(number);
      return !(value < schema.minimum || value > schema.maximum || value <= schema.exclusiveMinimum || value >= schema.exclusiveMaximum);
    };
    const limits = [schema.minimum, schema.maximum].filter((limit) => limit !== undefined);
    return this.pick([...limits, ...limits, ...WHOLE, ...(type === "number" ? FRACTIONS : [])].filter(fits));
  }

  // [owner, name, schema] of each value that the steps lead to.
  reach(holder, steps) {
    let reached = [[holder, "message", this.schema]];
    for (const { member, item, branch } of steps) {
      reached = reached.flatMap(([owner, name, schema]) => {
        const value = owner[name];
        if (item) return Array.isArray(value) ? value.map((_, i) => [value, i, schema.items]) : [];
        if (!isObject(value)) return [];
        if (branch !== undefined) return meets(schema.allOf[branch].if, value) ? [[owner, name, schema.allOf[branch].then]] : [];
        return member in value ? [[value, member, schema.properties[member]]] : [];
      });
    }
    return reached;
  }

  break({ keyword, name: missing }, owner, name, schema) {
    const limit = schema[keyword];
    if (keyword === "required") {
      if (isObject(owner[name])) delete owner[name][missing];
    } else if (keyword === "minItems") {
      if (Array.isArray(owner[name])) owner[name].length = Math.min(owner[name].length, limit - 1 - this.below(limit));
    } else {
      owner[name] = this.wrong(keyword, limit, schema);
    }
  }

  wrong(keyword, limit, schema) {
    const whole = schema.type?.includes("integer");
    const hair = whole ? 1 : Math.max(1, Math.abs(limit)) * 1e-12;
    switch (keyword) {
      case "type": return this.pick(Object.keys(OTHERS).filter((type) => !isOf(type, schema.type)).flatMap((type) => OTHERS[type]));
      case "enum": {
        const word = this.pick(limit);
        return this.pick(["", "UNKNOWN", word.toLowerCase(), `${word} `, word.slice(1)].filter((each) => !limit.includes(each)));
      }
      case "format": return this.pick(NO_DATES);
      case "minimum": return this.pick([limit - 1, limit - hair, limit - 1e6]);
      case "maximum": return this.pick([limit + 1, limit + hair, limit + 1e6, new Written("1e300")]);
      default: return limit;  // exclusive
    }
  }

  // mulberry32
  random() {
    this.state = (this.state + 0x6d2b79f5) | 0;
    let t = Math.imul(this.state ^ (this.state >>> 15), 1 | this.state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  }
  below(limit) { return Math.floor(this.random() * limit); }
  chance(share) { return this.random() < share; }
  pick(list) { return list[this.below(list.length)]; }
}

const isObject = (value) => value !== null && typeof value === "object" && !Array.isArray(value) && !(value instanceof Written);
const isOf = (type, allowed) => allowed.includes(type) || (type === "integer" && allowed.includes("number"));

// Of `if`, what zone sets need: members that must have one value. Absent ones meet it.
function meets(condition, value) {
  return Object.entries(condition.properties).every(([name, each]) => !(name in value) || value[name] === each.const);
}
