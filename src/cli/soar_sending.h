// Sends one SoAR message and, when asked, waits until it is acknowledged.
#pragma once

#include <string_view>

#include "base/result.h"
#include "cli/options/global_options.h"
#include "cli/options/sending_options.h"
#include "cli/options/soar_options.h"
#include "cli/output/exit_code.h"

namespace fleetpub::cli {

class OptionSet;

/// Everything that a SoAR command takes besides its payload.
struct SoarSendingOptions {
  SoarOptions soar;
  SendingOptions sending;
  SoarWaitingOptions waiting;
};

void DeclareSoarSending(OptionSet& set, SoarSendingOptions& options);
/// For what nobody acknowledges.
void DeclareSoarSendingOnly(OptionSet& set, SoarSendingOptions& options);

/// `payload` is JSON.
[[nodiscard]] Result<ExitCode> SendSoarMessage(const SoarSendingOptions& options,
                                               soar::MessageType type, std::string_view payload,
                                               const Context& context);

}  // namespace fleetpub::cli
