// What became of an obligation of VDA 5050.
#pragma once

#include <cstdint>
#include <string_view>

namespace fleetpub::app {

/// kInconclusive: what was heard cannot show it. kSkipped: nobody looked.
enum class Verdict : std::uint8_t { kPass, kFail, kSkipped, kInconclusive };

/// `PASS`
[[nodiscard]] constexpr std::string_view GetName(Verdict verdict) {
  switch (verdict) {
    case Verdict::kPass:
      return "PASS";
    case Verdict::kFail:
      return "FAIL";
    case Verdict::kSkipped:
      return "SKIPPED";
    case Verdict::kInconclusive:
      break;
  }
  return "INCONCLUSIVE";
}

}  // namespace fleetpub::app
