#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "study/plan_error.h"
#include "study/plan_facts.h"
#include "study/plan_search.h"
#include <fumarole/scene_renderer.h>

// The plan: what a scene needs, and the cheapest settings that reach an error, or the least error
// that fits into a time. Pictures are drawn at full size and their errors told by references of a
// few of their pixels. An error is the root of relMSE (metrics.h) of the composite, of one frame.

namespace fumarole::study {

struct PlanOptions {
    std::string preset = "default";  ///< preset that `start` comes from
    Settings start;                  ///< where the search begins; what is fixed is set here
    std::vector<std::string> fixed;  ///< settings that stay as they are by name, `mode` too
    /// For all of it; references and tries are cut to fit.
    double seconds = 10;
    bool savings = true;  ///< measure what each fact saves
    /// Called with what is being done, and the share of the time that is over.
    std::function<void(std::string_view, double)> progress;
    const std::atomic<bool>* cancel = nullptr;
};

/// Settings that were tried.
struct PlanPoint {
    PlanTry tried;
    std::string name;    ///< as options of `fumarole render`: `--steps 32`; "" for the default
    RootError verified;  ///< error by fresh pixels alone
    bool front = false;  ///< no other one beats it in time and error
};

struct Plan {
    PlanGoal goal;
    std::vector<PlanFact> facts;
    std::vector<PlanPoint> points;  ///< points in the order in which they were tried, `start` first
    std::size_t choice = 0;         ///< place of the chosen one among the points
    bool met = false;               ///< the goal, by all pixels that were referred to
    double ms = 0,
           start_ms = 0;  ///< times of the choice and of the start [ms], measured anew at the end
    std::size_t pixels = 0;          ///< number of pixels that have a reference
    double tolerance = 0;            ///< tolerance of their references
    std::vector<std::string> notes;  ///< what to know before believing it
    const char* timing_method = "";
    double seconds = 0;  ///< seconds that it took

    [[nodiscard]] const PlanPoint& chosen() const { return points[choice]; }
};

struct PlanCancelled : std::runtime_error {
    PlanCancelled() : std::runtime_error("the plan was cancelled") {}
};

/// Leaves the renderer with the scene and with settings of its own.
/// @throws Error if the scene has no media, or can't be drawn with `start`; PlanCancelled.
Plan make_plan(const Scene& scene, SceneRenderer& renderer, const PlanGoal& goal,
               const PlanOptions& options);

}  // namespace fumarole::study
