// The obligations that are tested, as data: one file for each group of them.
//
// A case is a row and a function that checks a Run. A passive one looks at all that was heard; an
// active one sends, waits, and leaves the robot as it found it.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/conformance/run.h"
#include "vda5050/model/version.h"

namespace fleetpub::app::conformance {

/// What is done to the robot.
enum class Level : std::uint8_t {
  kListen,   ///< nothing is sent
  kActions,  ///< instant actions that move nothing
  kDrive,    ///< orders: it moves, or a deviant one may
};

/// `listen`
[[nodiscard]] constexpr std::string_view GetName(Level level) {
  return level == Level::kListen ? "listen" : level == Level::kActions ? "actions" : "drive";
}

struct Case {
  std::string_view id;  ///< `C01`
  Level level;
  vda5050::Version first;
  vda5050::Version last;
  std::string_view clause;  ///< of 3.0, then of 2.1 where that is another
  std::string_view says;    ///< the obligation, a sentence
  std::string_view limit;   ///< "": none
  std::string_view advice;  ///< to whoever makes the robot
  /// Null: a person has to act, and it is never run.
  CaseFinding (*check)(Run& run);

  [[nodiscard]] bool AppliesTo(vda5050::Version version) const {
    return first <= version && version <= last;
  }
};

[[nodiscard]] std::span<const Case> ConnectionCases();
[[nodiscard]] std::span<const Case> HeaderCases();
[[nodiscard]] std::span<const Case> StateCases();
[[nodiscard]] std::span<const Case> FactsheetCases();
[[nodiscard]] std::span<const Case> InstantActionCases();
[[nodiscard]] std::span<const Case> OrderCases();
[[nodiscard]] std::span<const Case> DrivingCases();
[[nodiscard]] std::span<const Case> OrderActionCases();
[[nodiscard]] std::span<const Case> EndingCases();

/// All of them, by group.
[[nodiscard]] std::vector<Case> ListCases();

struct CaseResult {
  Case of;
  CaseFinding finding;
};

struct Selection {
  Level level = Level::kListen;
  std::vector<std::string> only = {};  ///< ids, or a group's letter; none: all
  std::vector<std::string> skip = {};
  std::chrono::nanoseconds listen = seconds(40);  ///< at least so long in all

  /// Whether a case is among them, whatever its level.
  [[nodiscard]] bool Has(std::string_view id) const;
  /// Whether one of these is run, of all versions.
  [[nodiscard]] bool RunsAny(std::span<const Case> cases) const;
};

struct Outcome {
  std::vector<CaseResult> results;    ///< in the order of ListCases()
  std::vector<std::string> leftover;  ///< what could not be taken back
};
using Progress = std::function<void(const CaseResult& result)>;
/// Runs the cases: active ones first, the passive ones over all that was heard. Takes back what it did.
[[nodiscard]] Outcome Conduct(Run& run, const Selection& selection, const Progress& progress = {});

}  // namespace fleetpub::app::conformance
