// Sends one message to each of some robots, one or a hundred thousand: the way of a command, from
// whom it is for to what became of it.
#pragma once

#include "app/command_factory.h"
#include "app/deliver.h"
#include "app/environment.h"
#include "app/observer.h"
#include "base/result.h"

namespace fleetpub::app {

/// Asks who is meant where only the broker knows, and for consent where it is needed, then sends to
/// all of the robots, batch by batch, or to none when the message is invalid. Reports each end as it
/// becomes known. Errors: nothing was sent; or a message could not be made for one of the robots,
/// whose kind then is the message's own.
[[nodiscard]] Status SendCommand(const CommandRequest& request, const SendSettings& settings,
                                 const Environment& environment, Observer& observer);

}  // namespace fleetpub::app
