#include "support/json_schema.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <stdexcept>

#include "support/temp_folder.h"

namespace fumarole::test {

using Json = nlohmann::json;

namespace {

bool is_type(const Json& value, const std::string& type)
{
    if (type == "integer")
        return value.is_number() && value.get<double>() == std::floor(value.get<double>());
    return type == "number"    ? value.is_number()
           : type == "string"  ? value.is_string()
           : type == "boolean" ? value.is_boolean()
           : type == "array"   ? value.is_array()
                               : value.is_object();
}

}  // namespace

JsonSchema::JsonSchema(Json document) : document_(std::move(document))
{
    check_keywords(document_);
}

const JsonSchema& JsonSchema::of_scenes()
{
    static const JsonSchema schema(Json::parse(read_bytes(
        std::filesystem::path(FUM_TEST_DATA).parent_path() / "docs" / "scene.schema.json")));
    return schema;
}

void JsonSchema::check_keywords(const Json& schema) const
{
    static const std::set<std::string> plain{"$schema",
                                             "title",
                                             "description",
                                             "default",
                                             "examples",
                                             "$ref",
                                             "type",
                                             "required",
                                             "dependentRequired",
                                             "enum",
                                             "const",
                                             "minimum",
                                             "maximum",
                                             "exclusiveMinimum",
                                             "exclusiveMaximum",
                                             "minItems",
                                             "maxItems",
                                             "minLength",
                                             "unevaluatedProperties"};
    if (schema.is_boolean())
        return;
    for (const auto& [keyword, said] : schema.items()) {
        if (keyword == "$defs" || keyword == "properties") {
            for (const Json& inner : said)
                check_keywords(inner);
        } else if (keyword == "anyOf" || keyword == "allOf" || keyword == "prefixItems") {
            for (const Json& inner : said)
                check_keywords(inner);
        } else if (keyword == "items") {
            check_keywords(said);
        } else if (keyword == "$ref") {
            (void)target(said);
        } else if (!plain.contains(keyword)) {
            throw std::runtime_error(fmt::format("keyword '{}' of a schema is not known", keyword));
        }
    }
}

const Json& JsonSchema::target(const Json& reference) const
{
    return document_.at(Json::json_pointer(reference.get<std::string>().substr(1)));
}

std::vector<const Json*> JsonSchema::parts(const Json& schema) const
{
    std::vector<const Json*> found{&schema};
    const auto add = [&](const Json& other) {
        for (const Json* part : parts(other))
            found.push_back(part);
    };
    if (schema.contains("$ref"))
        add(target(schema["$ref"]));
    if (schema.contains("allOf"))
        for (const Json& other : schema["allOf"])
            add(other);
    return found;
}

std::set<std::string> JsonSchema::keys(const std::string& definition,
                                       const std::string& without) const
{
    std::set<std::string> found;
    for (const Json* part : parts(definitions().at(definition)))
        if (part->contains("properties"))
            for (const auto& [key, said] : part->at("properties").items())
                found.insert(key);
    if (!without.empty())
        for (const std::string& key : keys(without))
            found.erase(key);
    return found;
}

const Json& JsonSchema::key(const std::string& definition, const std::string& name) const
{
    for (const Json* part : parts(definitions().at(definition)))
        if (part->contains("properties") && part->at("properties").contains(name))
            return part->at("properties").at(name);
    throw std::runtime_error(fmt::format("'{}' has no key '{}'", definition, name));
}

std::string JsonSchema::problem(const Json& value, const std::string& definition) const
{
    return validate(definition.empty() ? document_ : definitions().at(definition), value, "");
}

std::string JsonSchema::validate(const Json& schema, const Json& value,
                                 const std::string& place) const
{
    if (schema.is_boolean())
        return schema.get<bool>() ? "" : fmt::format("{}: may not be\n", place);
    std::string problems;
    const auto expect = [&](bool is_right, const std::string& keyword) {
        if (!is_right)
            problems += fmt::format("{}: {} {}\n", place, keyword, schema[keyword].dump());
    };
    const auto has = [&](const char* keyword) { return schema.contains(keyword); };
    if (has("$ref"))
        problems += validate(target(schema["$ref"]), value, place);
    if (has("allOf"))
        for (const Json& one : schema["allOf"])
            problems += validate(one, value, place);
    if (has("anyOf")) {
        std::string of_all;
        const auto& ways = schema["anyOf"];
        if (!std::any_of(ways.begin(), ways.end(), [&](const Json& one) {
                const std::string problem = validate(one, value, place);
                of_all += problem;
                return problem.empty();
            }))
            problems += of_all;
    }
    if (has("type"))
        expect(is_type(value, schema["type"]), "type");
    if (has("const"))
        expect(value == schema["const"], "const");
    if (has("enum"))
        expect(std::find(schema["enum"].begin(), schema["enum"].end(), value) !=
                   schema["enum"].end(),
               "enum");
    if (value.is_number()) {
        const double number = value;
        if (has("minimum"))
            expect(number >= schema["minimum"], "minimum");
        if (has("maximum"))
            expect(number <= schema["maximum"], "maximum");
        if (has("exclusiveMinimum"))
            expect(number > schema["exclusiveMinimum"], "exclusiveMinimum");
        if (has("exclusiveMaximum"))
            expect(number < schema["exclusiveMaximum"], "exclusiveMaximum");
    }
    if (value.is_string() && has("minLength"))
        expect(value.get_ref<const std::string&>().size() >= schema["minLength"], "minLength");
    if (value.is_array()) {
        if (has("minItems"))
            expect(value.size() >= schema["minItems"], "minItems");
        if (has("maxItems"))
            expect(value.size() <= schema["maxItems"], "maxItems");
        const std::size_t first = has("prefixItems") ? schema["prefixItems"].size() : 0;
        for (std::size_t i = 0; i < value.size(); ++i) {
            const std::string inner = fmt::format("{}[{}]", place, i);
            if (i < first)
                problems += validate(schema["prefixItems"][i], value[i], inner);
            else if (has("items"))
                problems += validate(schema["items"], value[i], inner);
        }
    }
    if (value.is_object())
        problems += validate_object(schema, value, place);
    return problems;
}

std::string JsonSchema::validate_object(const Json& schema, const Json& value,
                                        const std::string& place) const
{
    std::string problems;
    const auto need = [&](const Json& names) {
        for (const std::string name : names)
            if (!value.contains(name))
                problems += fmt::format("{}: no '{}'\n", place, name);
    };
    if (schema.contains("required"))
        need(schema["required"]);
    if (schema.contains("dependentRequired"))
        for (const auto& [name, others] : schema["dependentRequired"].items())
            if (value.contains(name))
                need(others);
    if (schema.contains("properties"))
        for (const auto& [name, inner] : schema["properties"].items())
            if (value.contains(name))
                problems += validate(inner, value[name], place + "." + name);
    if (schema.contains("unevaluatedProperties")) {
        const auto all = parts(schema);
        for (const auto& [name, inner] : value.items())
            if (std::none_of(all.begin(), all.end(), [&, &key = name](const Json* part) {
                    return part->contains("properties") && part->at("properties").contains(key);
                }))
                problems += fmt::format("{}: unknown key '{}'\n", place, name);
    }
    return problems;
}

}  // namespace fumarole::test
