#include "study/bench_goals.h"

#include <fmt/format.h>

namespace fumarole::study {

std::vector<BenchGoal> bench_goals(std::span<const BenchFigure> figures,
                                   std::span<const BenchScene> scenes)
{
    std::vector<BenchGoal> goals;
    const std::string faster = std::string(kTimesFaster) + "eevee2017";
    for (const BenchScene& scene : scenes) {
        const auto of = [&](const char* preset, std::string_view quantity) {
            return find_figure(figures, "presets", scene.name, preset, quantity);
        };
        if (const BenchFigure* f = of("default", faster)) {
            const double bound = is_marched(scene.scene) ? 10 : 3;
            goals.push_back(
                {fmt::format("{}: default {} times faster than eevee2017", scene.name, bound),
                 f->value.median, bound, true});
        }
        const BenchFigure *own = of("default", kCompositeError),
                          *old = of("eevee2017", kCompositeError);
        if (own != nullptr && old != nullptr)
            goals.push_back({fmt::format("{}: default's relMSE no greater", scene.name),
                             own->value.median, old->value.median, false});
        if (const BenchFigure* f = of("default", kMarchShare))
            goals.push_back({fmt::format("{}: march at 0.6 of the texel rate", scene.name),
                             f->value.median, 0.6, true});
    }
    for (const BenchFigure& f : figures) {
        if (f.group == "memory" && f.name == "auto" && f.quantity == "times the stored values")
            goals.push_back(
                {fmt::format("{}: bytes at most 1.5 times its active values' in the file", f.scene),
                 f.value.median, 1.5, false});
        if (f.group == "programs" && f.name == kFirstPicture)
            goals.push_back({fmt::format("{}: first picture within 1500 ms", f.scene),
                             f.value.median, 1500, false});
    }
    return goals;
}

}  // namespace fumarole::study
