// The options of everything that sends SoAR messages: whom they are for, who sends, how far an
// acknowledgement is waited for; and options made from the tables of a payload's fields.
#pragma once

#include <array>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/choice.h"
#include "base/result.h"
#include "cli/options/global_options.h"
#include "cli/parser/option.h"
#include "delivery/pending_commands.h"
#include "soar/field.h"
#include "soar/message.h"

namespace fleetpub::cli {

class OptionSet;

struct SoarOptions {
  std::string destination;
  bool broadcast = false;
  std::string prefix = "soar";
  std::string source = "fleetpub";
  std::string header_version = std::string(soar::kFormatVersion);
  bool strict = false;
};

struct SoarWaitingOptions {
  bool wait = false;
  std::optional<soar::Level> wait_for;  ///< nothing: as `wait` says
  /// In total; nothing: 35 s to be seen, 10 min to be done.
  std::optional<std::chrono::milliseconds> timeout;
  std::optional<std::size_t> acknowledgements;
  std::vector<std::string> topics;
};

/// Of `--protocol`: whether it is SoAR.
inline constexpr auto kProtocols =
    std::to_array<base::Choice<bool>>({{"vda5050", false}, {"soar", true}});

void DeclareSoarOptions(OptionSet& set, SoarOptions& options);
void DeclareSoarWaiting(OptionSet& set, SoarWaitingOptions& options);
/// `--prefix` alone.
void DeclarePrefix(OptionSet& set, std::string& prefix);
/// `--source` alone.
void DeclareSource(OptionSet& set, std::string& source);

/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<soar::Sender> ParseSender(const SoarOptions& options);
[[nodiscard]] Result<soar::Destination> ParseDestination(const SoarOptions& options,
                                                         const soar::Sender& sender,
                                                         soar::MessageType type);

/// What the waiting options ask for.
struct SoarWaiting {
  std::optional<soar::Level> wait_for;  ///< nothing: do not wait
  delivery::WaitOptions wait;
  std::size_t count = 1;
  std::vector<std::string> topics;  ///< empty: where acknowledgements usually come back
};
[[nodiscard]] Result<SoarWaiting> ParseSoarWaiting(const SoarWaitingOptions& options,
                                                   const soar::Destination& destination);

/// Options for the fields of a payload, each under a short name or in kebab case, and as the format
/// spells it.
class FieldOptions {
 public:
  void Declare(OptionSet& set, std::span<const soar::Field> fields);

  /// The members that were given. Errors: a required one is missing or a value is wrong
  /// (kUsage), a file cannot be read (kLedger).
  [[nodiscard]] Result<std::vector<soar::Member>> Members() const;

 private:
  struct Given {
    const soar::Field* field;
    Option option;
    std::string text;
  };
  std::deque<Given> given_;  // CLI11 keeps references to the texts
};

}  // namespace fleetpub::cli
