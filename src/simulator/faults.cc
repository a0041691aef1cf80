#include "simulator/faults.h"

#include <algorithm>
#include <array>

namespace fleetpub::simulator {
namespace {

using enum Fault;

constexpr auto kFaults = std::to_array<FaultFacts>({
    {kStuck, "stuck", "stops half-way along an edge, for good"},
    {kDeviation, "deviation", "reports a node 2 m beside it"},
    {kWrongLastNode, "wrong-last-node", "lastNodeId stays behind by one node"},
    {kEnterHorizon, "enter-horizon", "drives on where the base ends"},
    {kSkipTheta, "skip-theta", "does not turn to a node's theta"},
    {kIgnoreSpeedLimit, "ignore-speed-limit", "drives at its own speed on every edge"},
    {kStopAtNodes, "stop-at-nodes", "stops for half a second at every node"},
    {kNeverDriving, "never-driving", "driving is always false"},
    {kNodeBeforeEdge, "node-before-edge", "node and edge leave the state one after the other"},
    {kListFirstNode, "list-first-node", "a new order's first node is in nodeStates"},
    {kIgnoreUpdates, "ignore-updates", "ignores orders that update one"},
    {kAppendHorizon, "append-horizon", "an update leaves the old horizon in the state"},
    {kDropHorizon, "drop-horizon", "forgets the horizon at the end of the base"},
    {kOmitHorizonActions, "omit-horizon-actions", "actions of the horizon are not in the state"},
    {kRerunStitched, "rerun-stitched", "an update has the actions of its first node done again"},
    {kTakeAnyStitch, "take-any-stitch", "takes an update that begins anywhere"},
    {kTakeAnyStart, "take-any-start", "takes an order that begins anywhere"},
    {kExactStart, "exact-start",
     "takes no order that begins beside it, however large the allowed deviation"},
    {kTakeWhileBusy, "take-while-busy", "another order takes the place of the active one"},
    {kTakeAnyUpdateId, "take-any-update-id", "takes any orderUpdateId"},
    {kTakeUnsupported, "take-unsupported", "takes optional members that it cannot use"},
    {kTakeUnknownActions, "take-unknown-actions", "takes actions that it cannot do"},
    {kTakeUnknownMaps, "take-unknown-maps", "takes nodes on maps that it does not have"},
    {kTakeAfterCancel, "take-after-cancel", "takes an update of a cancelled order"},
    {kTakeInAnyMode, "take-in-any-mode", "takes orders in every operating mode"},
    {kTakeMalformed, "take-malformed", "takes an order that breaks the specification"},
    {kTakeBaseBehindHorizon, "take-base-behind-horizon",
     "takes an order with something released behind its horizon"},
    {kTakeSequenceGaps, "take-sequence-gaps", "takes an order whose sequenceIds have gaps"},
    {kRefuseResend, "refuse-resend", "an order that comes again is an error"},
    {kSilentRejection, "silent-rejection", "refuses orders without an error"},
    {kBriefRejection, "brief-rejection", "the error of a refused order stands in one state only"},
    {kOrderErrorForAll, "order-error-for-all", "every refused order is an orderError"},
    {kNoReferences, "no-references", "errors have no references"},
    {kWipeOrderAtEnd, "wipe-order-at-end", "orderId is empty once the order is done"},
    {kNoEmptyOrder, "no-empty-order", "refuses an order of one node"},
    {kHardInParallel, "hard-in-parallel", "begins HARD actions beside others"},
    {kHardFirst, "hard-first", "begins HARD actions before all others"},
    {kSingleInParallel, "single-in-parallel", "begins SINGLE actions beside others"},
    {kSoftOneByOne, "soft-one-by-one", "does SOFT actions one after the other"},
    {kActionsNeverStop, "actions-never-stop", "drives on during SOFT and HARD actions"},
    {kNoneStops, "none-stops", "stands during NONE actions"},
    {kSingleStops, "single-stops", "stands during SINGLE actions"},
    {kEdgeActionsRunOn, "edge-actions-run-on", "an edge's actions do not end with it"},
    {kEdgeActionsEarly, "edge-actions-early",
     "an edge's actions begin at the node before it, beside those of the node"},
    {kNoLoads, "no-loads", "loads do not change"},
    {kFailureWipesOrder, "failure-wipes-order", "gives the order up when an action fails"},
    {kNeverRetriable, "never-retriable", "what could be tried again is FAILED"},
    {kCancelWipesOrderId, "cancel-wipes-order-id", "orderId is empty after cancelOrder"},
    {kCancelFinishedFirst, "cancel-finished-first",
     "cancelOrder is FINISHED before the robot stands"},
    {kCancelDropsActions, "cancel-drops-actions", "cancelOrder empties actionStates"},
    {kCancelAnyOrder, "cancel-any-order", "cancels whichever orderId is named"},
    {kNoCancelError, "no-cancel-error", "cancelOrder without an order is FINISHED"},
    {kPauseDrives, "pause-drives", "drives on while it is paused"},
    {kPauseLosesOrder, "pause-loses-order", "gives the order up when it is paused"},
    {kPauseOnce, "pause-once", "startPause fails when it is paused already"},
    {kLoseStates, "lose-states", "every third state is lost"},
    {kNoStateOnStatus, "no-state-on-status", "an actionStatus is not worth a state"},
    {kNoStateOnChange, "no-state-on-change", "states come at the interval only"},
    {kNoStateOnRequest, "no-state-on-request", "stateRequest is FINISHED, but no state comes"},
    {kNewBaseNever, "new-base-never", "never asks for a new base"},
    {kNewBaseStuck, "new-base-stuck", "newBaseRequest stays true"},
    {kLowerCase, "lower-case", "an actionStatus is in lower case"},
    {kDegrees, "degrees", "theta is in degrees"},
    {kInstantInActionStates, "instant-in-action-states",
     "3.0: instant actions are in actionStates"},
    {kForgetInstantActions, "forget-instant-actions", "ended instant actions leave the state"},
    {kInstantActionsOverOrder, "instant-actions-over-order",
     "ended instant actions outlast a new order up to 2.1, and do not from 3.0"},
    {kHeaderIdRestart, "header-id-restart", "headerId begins anew after ten messages"},
    {kHeaderIdZero, "header-id-zero", "headerId is always 0"},
    {kHeaderIdShared, "header-id-shared", "one headerId counts for all topics"},
    {kHeaderVersion, "header-version", "version is v3, v2 or v1"},
    {kHeaderName, "header-name", "serialNumber is empty"},
    {kLocalTime, "local-time", "timestamp has no Z"},
    {kNoOnline, "no-online", "no ONLINE after a lost connection"},
    {kNoOffline, "no-offline", "leaves without OFFLINE"},
    {kConnectionNotRetained, "connection-not-retained", "connection is not retained"},
    {kConnectionQos0, "connection-qos-0", "connection has QoS 0"},
    {kOldBroken, "old-broken", "the last will has the other spelling of CONNECTION_BROKEN"},
    {kNoWill, "no-will", "has no last will"},
    {kLateWill, "late-will", "the last will comes after ten minutes of silence"},
    {kFactsheetNotRetained, "factsheet-not-retained", "factsheet is not retained"},
    {kFactsheetNotLive, "factsheet-not-live", "factsheetRequest is FINISHED, but nothing comes"},
    {kFactsheetWithoutActions, "factsheet-without-actions", "the factsheet lists no actions"},
    {kNoVisualization, "no-visualization", "the visualization that it promises does not come"},
    {kVisualizationWithoutReference, "visualization-without-reference",
     "3.0: referenceStateHeaderId is missing"},
});

static_assert(kFaults.size() == static_cast<std::size_t>(kCount));
static_assert(std::is_sorted(kFaults.begin(), kFaults.end(),
                             [](const FaultFacts& a, const FaultFacts& b) {
                               return a.fault < b.fault;
                             }));

}  // namespace

std::span<const FaultFacts> ListFaults() { return kFaults; }

std::optional<Fault> FindFault(std::string_view name) {
  const auto* const found = std::find_if(kFaults.begin(), kFaults.end(),
                                         [&](const FaultFacts& one) { return one.name == name; });
  return found == kFaults.end() ? std::nullopt : std::optional(found->fault);
}

}  // namespace fleetpub::simulator
