#pragma once

#include <nlohmann/json.hpp>
#include <set>
#include <string>

// As much of JSON Schema (draft 2020-12) as docs/scene.schema.json uses.

namespace fumarole::test {

class JsonSchema {
public:
    /// @throws std::runtime_error if it has a keyword that is not known here
    explicit JsonSchema(nlohmann::json document);

    /// The scene format's.
    static const JsonSchema& of_scenes();

    /// What is wrong with a value, a line for each way in which it could have been right; "" if it
    /// is valid.
    /// @param definition of $defs; "": the whole document
    [[nodiscard]] std::string problem(const nlohmann::json& value,
                                      const std::string& definition = "") const;

    [[nodiscard]] const nlohmann::json& definitions() const { return document_.at("$defs"); }
    /// Those of an object, its own and what it takes from others, without those that `without` has.
    [[nodiscard]] std::set<std::string> keys(const std::string& definition,
                                             const std::string& without = "") const;
    /// What a definition says of a key that it or another one that it takes from has.
    [[nodiscard]] const nlohmann::json& key(const std::string& definition,
                                            const std::string& name) const;

private:
    void check_keywords(const nlohmann::json& schema) const;
    [[nodiscard]] const nlohmann::json& target(const nlohmann::json& reference) const;
    /// The schemas whose properties an object has: this one, and those that it refers to.
    [[nodiscard]] std::vector<const nlohmann::json*> parts(const nlohmann::json& schema) const;
    [[nodiscard]] std::string validate(const nlohmann::json& schema, const nlohmann::json& value,
                                       const std::string& place) const;
    [[nodiscard]] std::string validate_object(const nlohmann::json& schema,
                                              const nlohmann::json& value,
                                              const std::string& place) const;

    nlohmann::json document_;
};

}  // namespace fumarole::test
