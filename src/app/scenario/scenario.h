// Scenarios of a user's own: tests as steps, from files in TOML.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/json.h"
#include "base/result.h"
#include "config/config.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::app::scenario {

enum class StepKind : std::uint8_t {
  kSimulate,  ///< virtual robots are there until the test ends
  kSend,      ///< a command of fleetpub's
  kExpect,    ///< conditions hold now, or all the time
  kAwait,     ///< conditions hold by and by
  kCapture,   ///< a value is given a name
};

struct Step {
  StepKind kind = StepKind::kSend;
  unsigned line = 0;
  std::string text;  ///< for people: `await paused=true`
  std::chrono::milliseconds within{};

  std::vector<std::string> words;  ///< of kSimulate and kSend: without the program
  std::string payload;             ///< of kSend: its standard input
  std::string outcome;             ///< of kSend: `FINISHED`; "": it succeeds
  /// Of kSimulate the robots, of kSend those that may not be commanded unasked, as people name them.
  std::vector<std::string> targets;

  vda5050::RobotAddress robot;  ///< of the others: whose message
  std::string topic = "state";
  std::vector<std::string> conditions;  ///< one message satisfies all
  std::chrono::milliseconds hold{0};    ///< of kExpect: for so long
  std::string path;                     ///< of kCapture
  std::string name;                     ///< of kCapture
};

struct Test {
  std::string name;
  unsigned line = 0;
  std::string skip;  ///< why it is not run; "": it is
  std::vector<Step> steps;

  /// Whom it commands although no step simulates it.
  [[nodiscard]] std::vector<std::string> ListReal() const;
};

struct Suite {
  std::string file;
  std::vector<Test> tests;
};

/// Looks at the words of a simulate or send step, and sets its targets. Errors: what to write.
using CommandCheck = std::function<Status(Step& step)>;

/// Goes on behind a mistake; each begins with `FILE:LINE:COLUMN: `.
[[nodiscard]] Suite ReadSuite(std::string_view text, const std::string& file,
                              const config::Config& config, const CommandCheck& check,
                              config::Mistakes& mistakes);

// ---- Variables: `${name}` ----

/// By name, what was captured: a text, number or boolean.
using Variables = std::map<std::string, base::JsonDocument, std::less<>>;

/// The names in a text. Errors: ErrorKind::kUsage: a `${` without name or end.
[[nodiscard]] Result<std::vector<std::string>> FindVariables(std::string_view text);

enum class Into : std::uint8_t { kText, kJson };
/// The text with its values; inside JSON, texts are escaped. All of them are known.
[[nodiscard]] std::string Expand(std::string_view text, const Variables& variables, Into into);

}  // namespace fleetpub::app::scenario
