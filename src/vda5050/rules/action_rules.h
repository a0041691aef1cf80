// What the specification's text asks of an action, wherever it stands: in instantActions, at a
// node, an edge or a zone.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/rapidjson.h"
#include "message/command.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::vda5050 {

using Findings = std::vector<message::TextFinding>;

void AddError(Findings& findings, std::string path, std::string message);
void AddWarning(Findings& findings, std::string path, std::string message);

/// The parameters of a predefined action: complete, of the table's types, none twice. Warned about:
/// keys that nearly are predefined ones, parameters that another version predefines. `parameters`
/// may be null; `path` is the action's.
void CheckActionParameters(const ActionSpec& action, const base::JsonValue* parameters,
                           const std::string& path, Findings& findings);

/// A type that no version predefines is a manufacturer's own, or a slip.
void CheckUnknownType(std::string_view type, const std::string& path, Version version,
                      Findings& findings);

/// Of the recommended characters (§6.1), else a warning; `path` is of the object whose member
/// `name` the id is.
void CheckIdCharacters(std::string_view id, const std::string& path, std::string_view name,
                       Findings& findings);

/// Not empty, not in `ids` yet, of the recommended characters.
void CheckActionId(std::string_view id, const std::string& path, std::set<std::string_view>& ids,
                   Findings& findings);

}  // namespace fleetpub::vda5050
