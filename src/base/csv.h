// Comma-separated values (RFC 4180).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace fleetpub::base {

struct CsvRow {
  std::size_t line = 0;  ///< where it begins, counted from 1
  std::vector<std::string> fields;
};

/// All rows; empty lines are passed over. Lines end in LF or CRLF, a field in quotation marks may
/// hold commas, line breaks and doubled quotation marks; a byte order mark is passed over. Errors:
/// ErrorKind::kInvalid, `line 3: …`.
[[nodiscard]] Result<std::vector<CsvRow>> ParseCsv(std::string_view text);

}  // namespace fleetpub::base
