// Schema files of a user's own: which schema a file holds, told from where it lies, and what it
// refers to in the files beside it.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/result.h"

namespace fleetpub::schema {

/// By the names under which schemas are known: `vda5050/3.0.0/order`.
using SchemaFiles = std::map<std::string, std::filesystem::path, std::less<>>;

/// The schema files of a folder and of those in it. What ends in `.schema.json`, `.schema` or
/// `.openapi.json` is one; its name is its path without the ending, except that
///
///  - `vda5050/` may be missing before a version;
///  - a version may be written `v3.0`, or have something behind it: `1.1.0-community`;
///  - a folder `json_schemas`, as in the official repository, may be around the files;
///  - a topic may be written `instant-actions`;
///  - a topic's file in the folder itself is that topic's schema in every version that has no file
///    of its own there.
///
/// Errors: ErrorKind::kUsage, when the folder cannot be read, holds no schema file, or two for one
/// name.
[[nodiscard]] Result<SchemaFiles> ScanSchemaFolder(const std::filesystem::path& folder);

/// The schema files in the folder of a file, it included.
[[nodiscard]] std::vector<std::filesystem::path> FilesBeside(const std::filesystem::path& file);

/// The file's text, complete: with a copy of what it refers to in `others`, which it names by path
/// or by `$id`. A file that is no JSON or refers to no other is returned as it stands. Errors: as
/// base::ReadFile; ErrorKind::kInvalid when what it refers to is not there or no JSON.
[[nodiscard]] Result<std::string> ReadSchemaFile(const std::filesystem::path& file,
                                                 const std::vector<std::filesystem::path>& others);

}  // namespace fleetpub::schema
