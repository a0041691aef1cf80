// The layout that a command works with: a file that is named, else the configuration's.
#pragma once

#include <string>

#include "base/result.h"
#include "cli/options/global_options.h"
#include "layout/layout.h"

namespace fleetpub::cli {

class OptionSet;

/// The words FILE; without it the configuration's `layout`.
void DeclareLayoutFile(OptionSet& set, std::string& file);

/// What is in it. What is wrong with it is told in a line. Errors: ErrorKind::kUsage (none is named),
/// kLedger, kInvalid.
[[nodiscard]] Result<layout::Site> LoadLayout(const std::string& file, Output& output);

/// `standard input` of `-`; else as it may be shown.
[[nodiscard]] std::string ShownFile(const std::string& file);

}  // namespace fleetpub::cli
