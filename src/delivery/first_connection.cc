#include "delivery/first_connection.h"

#include <thread>
#include <utility>

#include "delivery/reconnect.h"

namespace fleetpub::delivery {

Result<std::unique_ptr<mqtt::Transport>> Connect(const FirstConnection& connection,
                                                 mqtt::Deadline end) {
  using Clock = ReconnectSchedule::Clock;
  ReconnectSchedule schedule;
  for (bool is_told = false;;) {
    bool may_heal = false;
    auto transport = connection.open(end, may_heal);
    schedule.Lost(Clock::now());
    if (transport || !may_heal || schedule.next() >= end) return transport;
    if (!std::exchange(is_told, true)) connection.waits(transport.error());
    std::this_thread::sleep_until(schedule.next());
  }
}

}  // namespace fleetpub::delivery
