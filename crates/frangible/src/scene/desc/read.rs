//! Descriptions from plain data. An error names path, value and rule: the data is
//! checked against the schema that the descriptions themselves make, before it becomes one.

use crate::scene::check::{BuildError, nearest};
use crate::scene::desc::SceneDesc;
use schemars::{JsonSchema, SchemaGenerator};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

/// An object with this key alone stands for what JSON has no word for: its text is what a sentence
/// shows.
const NO_JSON: &str = "";

/// Longer texts are shortened in sentences [characters].
const LONGEST_SHOWN: usize = 40;

/// A value that no description takes, for sentences: NaN, a number out of all bounds, a foreign
/// type.
pub fn no_json(shown: &str) -> Value {
    Value::Object([(NO_JSON.to_owned(), shown.into())].into_iter().collect())
}

/// The JSON Schema of a description.
pub fn schema<T: JsonSchema>() -> Value {
    SchemaGenerator::default().into_root_schema_for::<T>().to_value()
}

/// A description from plain data that stands at `path`, which is empty for a scene. A whole number
/// may be written with a point.
///
/// # Errors
/// The first thing that does not fit: its path, its value and the rule.
pub fn read<T: JsonSchema + DeserializeOwned>(
    mut value: Value,
    path: &str,
) -> Result<T, BuildError> {
    let schema = schema::<T>();
    Reader { root: &schema }.check(&schema, &mut value, path)?;
    serde_json::from_value(value).map_err(|error| rule(path, "this value", &error.to_string()))
}

impl SceneDesc {
    /// A scene from JSON.
    ///
    /// # Errors
    /// The sentence for text that is no JSON, with line and column, or for the first value
    /// that does not fit: its path, its value and the rule.
    pub fn from_json(text: &str) -> Result<Self, BuildError> {
        if let Ok(scene) = serde_json::from_str(text) {
            return Ok(scene);
        }
        let value = serde_json::from_str(text)
            .map_err(|error| rule("scene", "this text", &format!("JSON ({error})")))?;
        Self::from_value(value)
    }

    /// A scene from plain data.
    ///
    /// # Errors
    /// The first thing that does not fit: its path, its value and the rule.
    pub fn from_value(value: Value) -> Result<Self, BuildError> {
        let names: Vec<Option<String>> = match value.get("bodies") {
            Some(Value::Array(bodies)) => bodies.iter().map(name_of).collect(),
            _ => Vec::new(),
        };
        read(value, "").map_err(|error| error.in_body(&names))
    }
}

fn name_of(body: &Value) -> Option<String> {
    body.get("name").and_then(Value::as_str).map(Into::into)
}

struct Reader<'a> {
    /// With what its parts refer to.
    root: &'a Value,
}

impl<'a> Reader<'a> {
    fn check(&self, schema: &'a Value, value: &mut Value, path: &str) -> Result<(), BuildError> {
        let schema = self.resolve(schema);
        if let Some(alternatives) = alternatives(schema) {
            return self.check_one_of(schema, alternatives, value, path);
        }
        if let Some(words) = schema.get("enum").and_then(Value::as_array) {
            let words: Vec<&str> = words.iter().filter_map(Value::as_str).collect();
            return check_word(value, &words, path);
        }
        match value {
            Value::Null if allows(schema, "null") => Ok(()),
            Value::Bool(_) if allows(schema, "boolean") => Ok(()),
            Value::Number(number) if allows(schema, "number") && number.as_f64().is_some() => {
                Ok(())
            }
            Value::Number(_) if allows(schema, "integer") => self.check_whole(schema, value, path),
            Value::String(_) if allows(schema, "string") => Ok(()),
            Value::Array(items) if allows(schema, "array") => self.check_items(schema, items, path),
            Value::Object(fields) if allows(schema, "object") && !fields.contains_key(NO_JSON) => {
                self.check_fields(schema, fields, path)
            }
            _ => Err(rule(path, &shown(value), &self.rule_of(schema))),
        }
    }

    /// The schema that a schema refers to, or itself.
    fn resolve(&self, schema: &'a Value) -> &'a Value {
        let named =
            schema.get("$ref").and_then(Value::as_str).and_then(|name| name.strip_prefix('#'));
        named.and_then(|pointer| self.root.pointer(pointer)).unwrap_or(schema)
    }

    /// One of several: words, objects that differ in their kind, or values that differ in their
    /// type.
    fn check_one_of(
        &self,
        schema: &'a Value,
        alternatives: &'a [Value],
        value: &mut Value,
        path: &str,
    ) -> Result<(), BuildError> {
        if value.is_null() && alternatives.iter().any(|other| allows(other, "null")) {
            return Ok(());
        }
        // Words.
        let words: Vec<&str> = alternatives.iter().filter_map(word_of).collect();
        if words.len() == alternatives.len() {
            return check_word(value, &words, path);
        }
        // Kinds.
        let kinds: Vec<&str> = alternatives.iter().filter_map(kind_of).collect();
        if let (true, Value::Object(fields)) = (kinds.len() == alternatives.len(), &mut *value)
            && !fields.contains_key(NO_JSON)
        {
            let at_kind = join(path, "kind");
            let Some(kind) = fields.get("kind") else {
                return Err(rule(&at_kind, "missing", &format!("one of {}", kinds.join(", "))));
            };
            check_word(kind, &kinds, &at_kind)?;
            let place = kinds.iter().position(|&known| kind.as_str() == Some(known));
            return place.map_or(Ok(()), |place| self.check(&alternatives[place], value, path));
        }
        // Types.
        for other in alternatives {
            if self.is_alike(other, value) {
                return self.check(other, value, path);
            }
        }
        Err(rule(path, &shown(value), &self.rule_of(schema)))
    }

    /// True if a value is of the type that a schema asks for, whatever is in it.
    fn is_alike(&self, schema: &'a Value, value: &Value) -> bool {
        let schema = self.resolve(schema);
        if let Some(inner) = alternatives(schema) {
            return inner.iter().any(|other| self.is_alike(other, value));
        }
        match value {
            Value::Null => allows(schema, "null"),
            Value::Bool(_) => allows(schema, "boolean"),
            Value::Number(_) => allows(schema, "number") || allows(schema, "integer"),
            Value::String(_) => allows(schema, "string"),
            Value::Array(_) => allows(schema, "array"),
            Value::Object(fields) => allows(schema, "object") && !fields.contains_key(NO_JSON),
        }
    }

    fn check_whole(
        &self,
        schema: &'a Value,
        value: &mut Value,
        path: &str,
    ) -> Result<(), BuildError> {
        const EXACT: f64 = (1_u64 << 53) as f64;
        let whole =
            value.as_f64().filter(|number| number.trunc() == *number && number.abs() <= EXACT);
        if let (None, Some(whole)) = (value.as_u64(), whole)
            && whole >= 0.0
        {
            *value = Value::from(whole as u64);
        }
        match value.as_u64() {
            Some(number) if number <= most(schema) => Ok(()),
            _ => Err(rule(path, &shown(value), &self.rule_of(schema))),
        }
    }

    fn check_items(
        &self,
        schema: &'a Value,
        items: &mut [Value],
        path: &str,
    ) -> Result<(), BuildError> {
        let bound = |name: &str| schema.get(name).and_then(Value::as_u64);
        let count = items.len() as u64;
        if bound("minItems").is_some_and(|least| count < least)
            || bound("maxItems").is_some_and(|most| count > most)
        {
            let given = shown(&Value::Array(items.to_vec()));
            return Err(rule(path, &given, &self.rule_of(schema)));
        }
        let Some(of_each) = schema.get("items") else { return Ok(()) };
        for (index, item) in items.iter_mut().enumerate() {
            // Most items are numbers: no path is written for them.
            if !(item.is_number() && allows(of_each, "number")) {
                self.check(of_each, item, &format!("{path}[{index}]"))?;
            }
        }
        Ok(())
    }

    fn check_fields(
        &self,
        schema: &'a Value,
        fields: &mut Map<String, Value>,
        path: &str,
    ) -> Result<(), BuildError> {
        let Some(known) = schema.get("properties").and_then(Value::as_object) else {
            return Ok(());
        };
        for (name, value) in fields.iter_mut() {
            let Some(of_field) = known.get(name) else {
                let names: Vec<&str> = known.keys().map(String::as_str).collect();
                let sentence = format!("one of {}{}", names.join(", "), nearest(name, &names));
                return Err(rule(&join(path, &short(name)), "an unknown field", &sentence));
            };
            self.check(of_field, value, &join(path, name))?;
        }
        let required = schema.get("required").and_then(Value::as_array).into_iter().flatten();
        for name in required.filter_map(Value::as_str) {
            if let (false, Some(of_field)) = (fields.contains_key(name), known.get(name)) {
                return Err(rule(&join(path, name), "missing", &self.rule_of(of_field)));
            }
        }
        Ok(())
    }

    /// The rule of a schema, in words.
    fn rule_of(&self, schema: &'a Value) -> String {
        let schema = self.resolve(schema);
        if let Some(alternatives) = alternatives(schema) {
            let words: Vec<&str> = alternatives.iter().filter_map(word_of).collect();
            if words.len() == alternatives.len() {
                return format!("one of {}", words.join(", "));
            }
            let kinds: Vec<&str> = alternatives.iter().filter_map(kind_of).collect();
            if kinds.len() == alternatives.len() {
                return format!("an object whose kind is one of {}", kinds.join(", "));
            }
            let not_null = alternatives.iter().filter(|other| !allows(other, "null"));
            return not_null.map(|other| self.rule_of(other)).collect::<Vec<_>>().join(", or ");
        }
        if allows(schema, "number") {
            return "a finite number".into();
        }
        if allows(schema, "integer") {
            let least = schema.get("minimum").and_then(Value::as_u64).unwrap_or(0);
            return format!("a whole number from {least} to {}", most(schema));
        }
        if allows(schema, "boolean") {
            return "true or false".into();
        }
        if allows(schema, "string") {
            return "text".into();
        }
        if allows(schema, "array") {
            let items = schema.get("items").map(|items| self.resolve(items));
            let noun = match items {
                Some(items) if allows(items, "number") => "numbers",
                Some(items) if allows(items, "integer") => "whole numbers",
                Some(items) if allows(items, "array") => "lists",
                Some(items) if allows(items, "string") => "texts",
                _ => "objects",
            };
            let count =
                schema.get("minItems").map_or_else(String::new, |count| format!("{count} "));
            return format!("a list of {count}{noun}");
        }
        let fields = schema.get("properties").and_then(Value::as_object);
        let names: Vec<&str> = fields.into_iter().flat_map(Map::keys).map(String::as_str).collect();
        format!("an object with fields of {}", names.join(", "))
    }
}

fn alternatives(schema: &Value) -> Option<&[Value]> {
    ["oneOf", "anyOf"]
        .iter()
        .find_map(|name| schema.get(*name))
        .and_then(Value::as_array)
        .map(Vec::as_slice)
}

/// True if a schema names a type.
fn allows(schema: &Value, name: &str) -> bool {
    match schema.get("type") {
        Some(Value::String(only)) => only == name,
        Some(Value::Array(several)) => several.iter().any(|one| one == name),
        _ => false,
    }
}

/// The word that a schema stands for, if it is one.
fn word_of(schema: &Value) -> Option<&str> {
    schema.get("const").and_then(Value::as_str)
}

/// The kind of the objects that a schema describes, if they have one.
fn kind_of(schema: &Value) -> Option<&str> {
    schema.pointer("/properties/kind/const").and_then(Value::as_str)
}

/// Largest number of an unsigned type.
fn most(schema: &Value) -> u64 {
    match schema.get("format").and_then(Value::as_str) {
        Some("uint32") => u64::from(u32::MAX),
        _ => u64::MAX,
    }
}

fn check_word(value: &Value, words: &[&str], path: &str) -> Result<(), BuildError> {
    let known = format!("one of {}", words.join(", "));
    match value.as_str() {
        Some(word) if words.contains(&word) => Ok(()),
        Some(word) => Err(rule(path, &shown(value), &format!("{known}{}", nearest(word, words)))),
        None => Err(rule(path, &shown(value), &known)),
    }
}

fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.into() } else { format!("{path}.{name}") }
}

fn rule(path: &str, value: &str, rule: &str) -> BuildError {
    let path = if path.is_empty() { "scene" } else { path };
    BuildError::Rule { path: path.into(), value: value.into(), rule: rule.into() }
}

/// A value in a sentence.
fn shown(value: &Value) -> String {
    match value {
        Value::Array(items) if items.len() > 8 => format!("a list of {} items", items.len()),
        Value::Object(fields) => match fields.get(NO_JSON) {
            Some(Value::String(text)) => short(text),
            _ if fields.len() > 4 => format!("an object of {} fields", fields.len()),
            _ => short(&value.to_string()),
        },
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Array(_) => {
            short(&value.to_string())
        }
    }
}

fn short(text: &str) -> String {
    if text.chars().count() <= LONGEST_SHOWN {
        return text.into();
    }
    let begin: String = text.chars().take(LONGEST_SHOWN - 4).collect();
    format!("{begin} ...")
}
