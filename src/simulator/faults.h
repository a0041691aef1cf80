// What virtual robots can do wrong on demand: one row each.
#pragma once

#include <bitset>
#include <optional>
#include <span>
#include <string_view>

namespace fleetpub::simulator {

enum class Fault {
  // driving
  kStuck,
  kDeviation,
  kWrongLastNode,
  kEnterHorizon,
  kSkipTheta,
  kIgnoreSpeedLimit,
  kStopAtNodes,
  kNeverDriving,
  kNodeBeforeEdge,
  kListFirstNode,
  // orders
  kIgnoreUpdates,
  kAppendHorizon,
  kDropHorizon,
  kOmitHorizonActions,
  kRerunStitched,
  kTakeAnyStitch,
  kTakeAnyStart,
  kExactStart,
  kTakeWhileBusy,
  kTakeAnyUpdateId,
  kTakeUnsupported,
  kTakeUnknownActions,
  kTakeUnknownMaps,
  kTakeAfterCancel,
  kTakeInAnyMode,
  kTakeMalformed,
  kTakeBaseBehindHorizon,
  kTakeSequenceGaps,
  kRefuseResend,
  kSilentRejection,
  kBriefRejection,
  kOrderErrorForAll,
  kNoReferences,
  kWipeOrderAtEnd,
  kNoEmptyOrder,
  // actions
  kHardInParallel,
  kHardFirst,
  kSingleInParallel,
  kSoftOneByOne,
  kActionsNeverStop,
  kNoneStops,
  kSingleStops,
  kEdgeActionsRunOn,
  kEdgeActionsEarly,
  kNoLoads,
  kFailureWipesOrder,
  kNeverRetriable,
  // cancelling and pausing
  kCancelWipesOrderId,
  kCancelFinishedFirst,
  kCancelDropsActions,
  kCancelAnyOrder,
  kNoCancelError,
  kPauseDrives,
  kPauseLosesOrder,
  kPauseOnce,
  // states
  kLoseStates,
  kNoStateOnStatus,
  kNoStateOnChange,
  kNoStateOnRequest,
  kNewBaseNever,
  kNewBaseStuck,
  kLowerCase,
  kDegrees,
  kInstantInActionStates,
  kForgetInstantActions,
  kInstantActionsOverOrder,
  // headers
  kHeaderIdRestart,
  kHeaderIdZero,
  kHeaderIdShared,
  kHeaderVersion,
  kHeaderName,
  kLocalTime,
  // connection
  kNoOnline,
  kNoOffline,
  kConnectionNotRetained,
  kConnectionQos0,
  kOldBroken,
  kNoWill,
  kLateWill,
  kFactsheetNotRetained,
  kFactsheetNotLive,
  kFactsheetWithoutActions,
  kNoVisualization,
  kVisualizationWithoutReference,
  kCount
};

struct FaultFacts {
  Fault fault;
  std::string_view name;  ///< what a person types
  std::string_view does;  ///< what the robot does then
};

/// All of them, in the order of the enum.
[[nodiscard]] std::span<const FaultFacts> ListFaults();

[[nodiscard]] std::optional<Fault> FindFault(std::string_view name);

class Faults {
 public:
  void Add(Fault fault) { bits_.set(static_cast<std::size_t>(fault)); }
  [[nodiscard]] bool Has(Fault fault) const { return bits_.test(static_cast<std::size_t>(fault)); }
  [[nodiscard]] bool Any() const { return bits_.any(); }

 private:
  std::bitset<static_cast<std::size_t>(Fault::kCount)> bits_;
};

}  // namespace fleetpub::simulator
