// How robots are shown: as rows of a table, as a line for each change, as JSON.
#pragma once

#include <array>
#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/choice.h"
#include "base/time.h"
#include "cli/output/table.h"
#include "vda5050/reports/robot_directory.h"

namespace fleetpub::cli {

[[nodiscard]] std::span<const Column> FleetColumns();

/// One robot; what is not known is `-`. `now` is for the age of its connection message.
/// `silence`: since it last sent a state; nothing: that is not known.
[[nodiscard]] Row FleetRow(const vda5050::ListedRobot& robot, base::WallTime now,
                           std::optional<std::chrono::nanoseconds> silence = {});

/// One robot with its columns named, for a line that stands alone.
[[nodiscard]] std::string FleetLine(const vda5050::ListedRobot& robot, const Output& output);

/// The members of a JSON object (docs/manual.md), without its braces.
[[nodiscard]] std::string FleetJson(const vda5050::ListedRobot& robot);

enum class SortBy { kTrouble, kName, kBattery, kAge };
inline constexpr std::array kSortings = {
    base::Choice<SortBy>{"trouble", SortBy::kTrouble}, base::Choice<SortBy>{"name", SortBy::kName},
    base::Choice<SortBy>{"battery", SortBy::kBattery}, base::Choice<SortBy>{"age", SortBy::kAge}};

/// Robots in order of address: the worst, the emptiest or those unheard for the longest first; of
/// alike ones in order of address.
void SortRobots(std::vector<const vda5050::ListedRobot*>& robots, SortBy by);

/// `12 s`, `3 min`, `5 h`, `9 d`.
[[nodiscard]] std::string AgeText(std::chrono::nanoseconds age);

}  // namespace fleetpub::cli
