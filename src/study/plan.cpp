#include "study/plan.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>

#include "light/surface_turns.h"
#include "medium/media_set.h"
#include "study/chart.h"
#include <fumarole/errors.h>

namespace fumarole::study {

namespace {

using Clock = std::chrono::steady_clock;
using Mode = Settings::Mode;

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

// When each part ends at the latest, in shares of the time; a part that needs less leaves the rest
// to the next. The first pictures take what they take.
constexpr double kReferenceEnd = 0.4, kSearchEnd = 0.75, kVerifyEnd = 0.9;

/// Of the time, what the guide may take.
constexpr double kGuideShare = 0.15;
/// Steps of the guide at full resolution; the most that there is time for.
constexpr std::array kGuideSteps{256, 128, 64, 32};

// Draws for the search and for the verification, at most, in batches.
constexpr int kSearchBatches = 40, kFreshBatches = 24;
constexpr std::size_t kLeastBatch = 48, kLargestBatch = 1024;
/// An error is known well enough when one standard error is this share of it. The start's is known
/// better than needed, for those of other settings that are less well known by the same pixels.
constexpr double kSureEnough = 0.04, kSureOfStart = 0.01;
constexpr std::size_t kLeastBatches = 8, kFewBatches = 10;

/// Of a try: frames timed at most, and seconds after which no more is.
constexpr int kFrames = 3;
constexpr double kFrameSeconds = 0.25;

// The references' tolerance of each pixel, in parts of the error asked for: theirs adds up with it
// in squares.
constexpr double kFineReference = 0.5;
constexpr double kFinest = 1e-3, kCoarsest = 0.02;
/// Where a time is asked for, and no error is known beforehand.
constexpr double kUnasked = 5e-3;

/// Times and errors that differ by less are the same; an error that falls by less hardly falls.
constexpr double kAsGood = 1.03, kHardlyLess = 0.9;

/// A depth below which it is tried whether shadows can be left out.
constexpr double kShadowless = 5 * kThin;

double tolerance_for(const PlanGoal& goal)
{
    return goal.kind == PlanGoal::Kind::max_error
               ? std::clamp(kFineReference * goal.value, kFinest, kCoarsest)
               : kUnasked;
}
/// Where light scatters on: noise is taken off, so more pixels say as much as finer ones.
constexpr double kCoarsestPaths = 0.2, kFinestPaths = 0.1;

class Planner {
public:
    Planner(const Scene& scene, SceneRenderer& renderer, const PlanGoal& goal,
            const PlanOptions& options)
        : scene_{scene}, renderer_{renderer}, goal_{goal}, options_{options}
    {
        plan_.goal = goal;
    }

    Plan run()
    {
        if (scene_.media.empty())
            throw Error("the scene has no media; there is nothing to plan");
        draw_first();
        refer();
        search();
        verify();
        finish();
        return std::move(plan_);
    }

private:
    // ------------------------------------------------------------------------------------ time

    [[nodiscard]] double passed() const
    {
        return std::chrono::duration<double>(Clock::now() - begin_).count();
    }
    [[nodiscard]] double left(double share) const { return share * options_.seconds - passed(); }

    void tell(std::string_view what) const
    {
        if (options_.cancel != nullptr && *options_.cancel)
            throw PlanCancelled();
        if (options_.progress)
            options_.progress(what, std::min(1.0, passed() / options_.seconds));
    }

    // ---------------------------------------------------------------------------------- frames

    /// A look at settings. What it took is kept to guess what the next one will.
    Glance glance(const Settings& settings, int frames = kFrames)
    {
        const auto begin = Clock::now();
        Glance found = renderer_.glance(scene_, settings, frames, kFrameSeconds);
        glance_s_ =
            std::chrono::duration<double>(Clock::now() - begin).count() - 1e-3 * found.setup_ms;
        glance_ms_ = found.volume.median_ms;
        held_ = settings;
        return found;
    }

    /// What a look at settings may take, a frame of which takes `ms`.
    [[nodiscard]] double guess_seconds(const Settings& settings, double ms) const
    {
        const double longer = glance_ms_ > 0 && std::isfinite(ms) ? ms / glance_ms_ : 1;
        double refills = 0;
        for (const PlanRow& row : plan_rows())
            if (row.mode == settings.mode &&
                find_setting(row.setting).get(settings) != find_setting(row.setting).get(held_))
                refills += row.refills;
        return glance_s_ * std::max(1.0, longer) + refills * setup_s_;
    }

    void draw_first()
    {
        tell("first pictures");
        Settings march = options_.start;
        march.mode = Mode::raymarch;
        march.resolution = Settings::kAutomatic;
        automatic_ = renderer_.settled(scene_, march).resolution;
        options_.start = with_resolution(options_.start);
        start_ = glance(options_.start);
        setup_s_ = 1e-3 * start_.setup_ms;
        glance_s_ = kFrameSeconds + 3e-3 * glance_ms_;  // the first one compiled its shaders too
        plan_.timing_method = timing_name(renderer_.renderer().measuring_timing());
        reference_ =
            std::make_unique<SparseReference>(scene_, guide(), coarsest(), bounces(),
                                              measured_surface_bounces(scene_), options_.cancel);
    }

    void draw(std::size_t batch_size)
    {
        batch_size_ = batch_size;
        reference_->set_draws(draw_pixels(drawing_density(reference_->guide(), scene_.resolution.x,
                                                          start_.composite, reference_->floor()),
                                          kSearchBatches + kFreshBatches,
                                          static_cast<int>(batch_size)));
    }

    /// The dearest picture for which there is time, with the volumes that there are; at worst the
    /// start's own.
    std::vector<float> guide()
    {
        Settings dear = options_.start;
        dear.mode = Mode::raymarch;
        dear.resolution = 1;
        const double texels = options_.start.resolution * options_.start.resolution;
        for (const int steps : kGuideSteps) {
            dear.steps = steps;
            const double longer = texels * steps / options_.start.steps;
            if (1e-3 * start_.volume.median_ms * longer > kGuideShare * options_.seconds)
                continue;
            tell("a dear picture to draw pixels by");
            guide_steps_ = steps;
            return renderer_.glance(scene_, dear, 0, 0).composite;
        }
        guide_steps_ = options_.start.steps;
        return start_.composite;
    }

    // ------------------------------------------------------------------------------- references

    /// Of the truth: light scatters once in it where that is asked for.
    [[nodiscard]] int bounces() const
    {
        return options_.start.bounces == 0 && is_fixed("bounces") ? 0 : kMeasuredBounces;
    }
    [[nodiscard]] double coarsest() const { return bounces() > 0 ? kCoarsestPaths : kCoarsest; }
    [[nodiscard]] double finest() const
    {
        return bounces() > 0 ? kFinestPaths : tolerance_for(goal_);
    }

    /// More draws from batch `first` on, until what is asked of `look` is known well enough or
    /// time is up. @returns the draws
    std::vector<std::size_t> refer_batches(int first, int batches, double end,
                                           const SparseReference::Look& look, double sure_enough)
    {
        std::vector<std::size_t> draws;
        for (int batch = first; batch < first + batches; ++batch) {
            const std::size_t done = draws.size();
            draws.resize(done + batch_size_);
            std::iota(draws.begin() + static_cast<std::ptrdiff_t>(done), draws.end(),
                      static_cast<std::size_t>(batch) * batch_size_);
            tell("references of single pixels");
            const auto begin = Clock::now();
            try {
                reference_->refer(std::span(draws).subspan(done));
            } catch (const ReferenceCancelled&) {
                throw PlanCancelled();
            }
            const double took = std::chrono::duration<double>(Clock::now() - begin).count();
            const RootError now = reference_->error(look, draws);
            const bool sure = draws.size() >= kLeastBatches * batch_size_ &&
                              now.surely < (1 + sure_enough) * now.error;
            if (sure || took > left(end))
                break;
        }
        return draws;
    }

    void refer()
    {
        draw(kLeastBatch);
        const auto begin = Clock::now();
        refer_batches(0, 1, 0, reference_->look(start_.composite), 0);
        // What a batch takes grows no faster than its pixels become exact. Few of them that are
        // exact say less than many that are not.
        double batch_s = std::chrono::duration<double>(Clock::now() - begin).count();
        double tolerance = coarsest();
        const double enough = left(kReferenceEnd) / kFewBatches;
        for (; tolerance > finest() && 2 * batch_s < enough; batch_s *= 2)
            tolerance = std::max(tolerance / 2, finest());
        if (tolerance < coarsest())
            reference_->set_tolerance(tolerance);
        if (tolerance > finest())
            plan_.notes.push_back(fmt::format(
                "the time limit left room for references to {:g} of each pixel, no finer ones",
                tolerance));
        plan_.tolerance = reference_->tolerance();
        // Batches as large as fit: what is cheap is asked often.
        const double fit =
            static_cast<double>(kLeastBatch) * left(kReferenceEnd) / (kSearchBatches * batch_s);
        draw(static_cast<std::size_t>(
            std::clamp(fit, static_cast<double>(kLeastBatch), static_cast<double>(kLargestBatch))));
        const SparseReference::Look look = reference_->look(start_.composite);
        draws_ = refer_batches(0, kSearchBatches, kReferenceEnd, look, kSureOfStart);
        guide_error_ = reference_->error(reference_->look(reference_->guide()), draws_);
        const Renderer& renderer = renderer_.renderer();
        depth_ = deepest_way(reference_->reference(), renderer.media_bounds(), scene_.lights);
    }

    // ----------------------------------------------------------------------------------- search

    [[nodiscard]] bool is_fixed(std::string_view setting) const
    {
        return std::find(options_.fixed.begin(), options_.fixed.end(), setting) !=
               options_.fixed.end();
    }

    /// Whether a row's setting does anything for this scene.
    [[nodiscard]] bool matters(const PlanRow& row) const
    {
        const medium::MediaTraits& media = renderer_.renderer().media_traits();
        if (row.setting == "targets")
            return media.colored_extinction;
        if (row.setting == "volume-shadows")
            return depth_ < kShadowless && !scene_.lights.empty();
        if (row.setting == "shadow-map")
            return !scene_.surfaces.empty() && !scene_.lights.empty();
        if (row.setting == "bounces")
            return media.scatters;
        if (row.setting == "surface-bounces")
            return light::surface_turns(scene_, {}).turns > 0;
        if (row.setting == "probes")
            return !renderer_.renderer().probes().empty();
        if (row.setting == "ambient-volume-size")
            return !is_black(scene_.world) || options_.start.bounces != 0;
        if (row.setting == "shadow-volume-size")
            return media.marched > 0 && !scene_.lights.empty();
        return true;
    }

    [[nodiscard]] std::vector<PlanRow> rows(Mode mode) const
    {
        std::vector<PlanRow> found;
        for (const PlanRow& row : plan_rows())
            if (row.mode == mode && !is_fixed(row.setting) && matters(row))
                found.push_back(row);
        // Where the guide errs as much, rays and steps can't mend it: what light they meet may.
        if (goal_.kind == PlanGoal::Kind::max_error && guide_error_.error > goal_.value &&
            guide_error_.error > kHardlyLess * plan_.points.front().tried.error)
            std::stable_partition(found.begin(), found.end(),
                                  [](const PlanRow& row) { return row.refills > 0; });
        return found;
    }

    const PlanTry& add(const Settings& settings, const Glance& found)
    {
        PlanPoint point;
        point.tried.settings = settings;
        point.tried.ms = found.volume.median_ms;
        looks_.push_back(reference_->look(found.composite));
        const RootError error = reference_->error(looks_.back(), draws_);
        point.tried.error = error.error;
        point.tried.surely = error.surely;
        point.name = options_of(settings);
        plan_.points.push_back(point);
        return plan_.points.back().tried;
    }

    std::optional<PlanTry> attempt(const Settings& settings, double ms)
    {
        for (const PlanPoint& point : plan_.points)
            if (point.tried.settings == settings)
                return point.tried;
        if (guess_seconds(settings, ms) > left(kSearchEnd)) {
            cut_ = true;
            return std::nullopt;
        }
        tell("settings");
        try {
            return add(settings, glance(settings));
        } catch (const Error&) {  // more than this GL has
            return PlanTry{settings, kUnbounded, kUnbounded, kUnbounded};
        }
    }

    void search()
    {
        const PlanTry start = add(options_.start, start_);
        const TrySettings attempts = [&](const Settings& settings, double ms) {
            return attempt(settings, ms);
        };
        const PlanTry best = search_plan(goal_, rows(options_.start.mode), start, attempts);
        if (!is_fixed("mode")) {
            Settings other = options_.start;
            other.mode = start.settings.mode == Mode::froxel ? Mode::raymarch : Mode::froxel;
            if (!is_fixed("history"))
                other.history = 0;  // of a single frame nothing is kept
            const std::optional<PlanTry> first = attempt(other, 2 * start.ms);
            if (first && !(first->ms >= best.ms && first->error >= best.error))
                search_plan(goal_, rows(other.mode), *first, attempts);
        }
        choose();
    }

    /// The best of all that were tried. Where several are as good as it in what counts, the best of
    /// those in the other.
    void choose()
    {
        std::vector<std::size_t> able(plan_.points.size());
        std::iota(able.begin(), able.end(), std::size_t{0});
        plan_.met = std::any_of(able.begin(), able.end(),
                                [&](std::size_t i) { return meets(goal_, plan_.points[i].tried); });
        if (plan_.met)
            std::erase_if(able,
                          [&](std::size_t i) { return !meets(goal_, plan_.points[i].tried); });
        double PlanTry::*first = &PlanTry::ms;
        double PlanTry::*second = &PlanTry::error;
        if ((goal_.kind == PlanGoal::Kind::max_error) != plan_.met)
            std::swap(first, second);
        const auto least = [&](double PlanTry::*what) {
            return *std::min_element(able.begin(), able.end(), [&](std::size_t a, std::size_t b) {
                return plan_.points[a].tried.*what < plan_.points[b].tried.*what;
            });
        };
        const double best = plan_.points[least(first)].tried.*first;
        std::erase_if(able,
                      [&](std::size_t i) { return plan_.points[i].tried.*first > kAsGood * best; });
        plan_.choice = least(second);
    }

    // ----------------------------------------------------------------------------- verification

    void verify()
    {
        const std::vector<std::size_t> fresh = refer_batches(
            kSearchBatches, kFreshBatches, kVerifyEnd, looks_[plan_.choice], kSureEnough);
        std::vector<std::size_t> all = draws_;
        all.insert(all.end(), fresh.begin(), fresh.end());
        std::vector<RootError> pooled;
        for (std::size_t i = 0; i < plan_.points.size(); ++i) {
            plan_.points[i].verified = reference_->error(looks_[i], fresh);
            pooled.push_back(reference_->error(looks_[i], all));
        }
        reconsider(pooled);
        std::vector<std::pair<double, double>> costs;
        for (const PlanPoint& point : plan_.points)
            costs.emplace_back(point.tried.ms, point.tried.error);
        const std::vector<bool> front = pareto_front(costs);
        for (std::size_t i = 0; i < front.size(); ++i)
            plan_.points[i].front = front[i];
        plan_.pixels = reference_->pixels_known();
    }

    /// The choice once more, by all pixels.
    void reconsider(const std::vector<RootError>& pooled)
    {
        const std::size_t before = plan_.choice;
        std::vector<PlanTry> predicted;
        for (std::size_t i = 0; i < plan_.points.size(); ++i) {
            predicted.push_back(plan_.points[i].tried);
            plan_.points[i].tried.error = pooled[i].error;
            plan_.points[i].tried.surely = pooled[i].surely;
        }
        const bool holds = meets(goal_, plan_.points[before].tried);
        const bool met = plan_.met;
        if (met && !holds)
            choose();
        for (std::size_t i = 0; i < plan_.points.size(); ++i)
            plan_.points[i].tried = predicted[i];
        if (plan_.choice != before)
            plan_.notes.push_back(fmt::format("fresh pixels refused '{}', which the search had "
                                              "chosen",
                                              plan_.points[before].name));
    }

    void finish()
    {
        tell("times anew");
        const Settings& choice = plan_.chosen().tried.settings;
        plan_.ms = glance(choice).volume.median_ms;
        plan_.start_ms = plan_.points.front().tried.ms;
        if (plan_.choice == 0)
            plan_.start_ms = plan_.ms;
        else if (guess_seconds(options_.start, plan_.start_ms) < left(1))
            plan_.start_ms = glance(options_.start).volume.median_ms;
        plan_.facts = scene_facts(scene_, renderer_.renderer().media_traits(), depth_, choice);
        if (const std::string placement = renderer_.renderer().probe_placement();
            !placement.empty())
            plan_.facts.push_back({placement});
        add_light_of_surfaces(choice);
        if (options_.savings)
            for (PlanFact& fact : plan_.facts)
                measure_saving(fact, choice);
        if (!plan_.met && goal_.kind == PlanGoal::Kind::max_error &&
            guide_error_.error > goal_.value)
            plan_.notes.push_back(
                fmt::format("at full resolution and {} steps the error is {:.2g} still: it lies in "
                            "the surfaces, their shadows or the volumes of light",
                            guide_steps_, guide_error_.error));
        if (plan_.met && goal_.kind == PlanGoal::Kind::budget && plan_.ms > goal_.value)
            plan_.notes.push_back(fmt::format("timed anew the choice took {:.2f} ms", plan_.ms));
        if (cut_)
            plan_.notes.push_back(fmt::format("the time limit of {:.3g} s ended the search before "
                                              "it was done",
                                              options_.seconds));
        plan_.seconds = passed();
    }

    /// What light from surfaces costs and gains: what they send on, and what probes have seen.
    void add_light_of_surfaces(const Settings& choice)
    {
        const light::SurfaceTurns turns = light::surface_turns(scene_, choice);
        if (!turns.why.empty())
            plan_.facts.push_back(
                {fmt::format("light that surfaces send on: {} ({})",
                             turns.turns == 0 ? "none"
                                              : fmt::format("{} turn{}", turns.turns,
                                                            turns.turns == 1 ? "" : "s"),
                             turns.why)});
        if (turns.turns > 0)
            plan_.facts.back().without = std::pair("surface-bounces", "0");
        const std::vector<ProbeState> probes = renderer_.renderer().probes();
        if (probes.empty() || choice.probes == Settings::Probes::off)
            return;
        double ms = 0;
        for (const ProbeState& probe : probes)
            ms += probe.capture_ms.value_or(0);
        plan_.facts.push_back(
            {fmt::format("{} probe{}{}", probes.size(), probes.size() == 1 ? "" : "s",
                         ms > 0 ? fmt::format(": {:.0f} ms to capture {} once", ms,
                                              probes.size() == 1 ? "it" : "all")
                                : ""),
             std::pair("probes", "off")});
    }

    void measure_saving(PlanFact& fact, const Settings& choice)
    {
        if (!fact.without)
            return;
        Settings without = choice;
        find_setting(fact.without->first).set(without, fact.without->second);
        const double longer = fact.without->first == "shadow-volume-size" ? choice.shadow_steps : 2;
        if (guess_seconds(without, longer * plan_.ms) > left(1))
            return;
        tell("what the scene saves");
        const Glance found = glance(without, 1);
        const double ms = found.volume.median_ms;
        if (ms > 0)
            fact.saving = 1 - plan_.ms / ms;
        if (fact.without->first == "probes" || fact.without->first == "surface-bounces")
            fact.errors = {plan_.chosen().tried.error,
                           reference_->error(reference_->look(found.composite), draws_).error};
    }

    /// What an automatic resolution is in this picture.
    [[nodiscard]] Settings with_resolution(Settings settings) const
    {
        if (settings.resolution == Settings::kAutomatic)
            settings.resolution = automatic_;
        return settings;
    }

    /// As options of `fumarole render`.
    [[nodiscard]] std::string options_of(const Settings& settings) const
    {
        const Settings preset = with_resolution(find_preset(options_.preset));
        std::string text =
            options_.preset == "default" ? "" : fmt::format(" --preset {}", options_.preset);
        if (settings.mode != preset.mode)
            text += fmt::format(" --mode {}", mode_name(settings.mode));
        for (const auto& [name, value] : differences(settings, preset))
            text += fmt::format(" --{} {}", name, value);
        return text.empty() ? text : text.substr(1);
    }

    const Scene& scene_;
    SceneRenderer& renderer_;
    const PlanGoal& goal_;
    PlanOptions options_;
    int automatic_ = 2;
    const Clock::time_point begin_ = Clock::now();

    Plan plan_;
    Glance start_;
    double setup_s_ = 0;                   ///< set-up of the first picture [s]
    double glance_s_ = 0, glance_ms_ = 0;  ///< the last look's time, and its volume's
    Settings held_;                        ///< settings of the last look, whose volumes are there
    std::unique_ptr<SparseReference> reference_;
    std::size_t batch_size_ = kLeastBatch;
    std::vector<std::size_t> draws_;            ///< pictures that the search goes by
    std::vector<SparseReference::Look> looks_;  ///< looks of the plan's points
    int guide_steps_ = 0;
    RootError guide_error_;  ///< guide error of the picture that pixels were drawn by
    double depth_ = 0;       ///< deepest_way()
    bool cut_ = false;       ///< true if the time limit cut the search
};

}  // namespace

Plan make_plan(const Scene& scene, SceneRenderer& renderer, const PlanGoal& goal,
               const PlanOptions& options)
{
    return Planner(scene, renderer, goal, options).run();
}

}  // namespace fumarole::study
