#include "bench_programs.h"

#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <glm/gtc/constants.hpp>
#include <glm/trigonometric.hpp>

#include "asset/printable.h"
#include "study/child_process.h"
#include "write/whole_file.h"

namespace fumarole::command {

namespace {

namespace fs = std::filesystem;

std::string triple(const glm::dvec3& v)
{
    return fmt::format("{:g},{:g},{:g}", v.x, v.y, v.z);
}

/// vdb_render's words for a scene's camera, medium and first sun.
std::vector<std::string> vdb_render_words(const fs::path& vdb, const Scene& scene,
                                          const GridMedium& medium, const fs::path& picture)
{
    const Camera& camera = scene.camera;
    const glm::dvec2 size(480, 270);
    const double width = std::tan(glm::radians(camera.vfov_deg) / 2) * size.x / size.y;
    std::vector<std::string> words{"vdb_render", vdb.string(), picture.string(), "-v"};
    const auto add = [&](const char* option, const std::string& value) {
        words.emplace_back(option);
        words.push_back(value);
    };
    add("-res", "480x270");
    add("-translate", triple(camera.position));
    add("-lookat", triple(camera.look_at));
    add("-up", triple(camera.up));
    add("-fov", fmt::format("{:g}", glm::degrees(2 * std::atan(width))));
    add("-step", "1");
    add("-shadowstep", "1");
    add("-scatter", triple(medium.sigma_s_per_density));
    add("-absorb", triple(medium.sigma_a_per_density));
    for (const Light& light : scene.lights)
        if (const auto* sun = std::get_if<SunLight>(&light)) {
            add("-light", triple(sun->direction_to_light) + ",1,1,1");
            break;
        }
    return words;
}

/// `...completed in 0.312 sec`, the last of them; 0 if it says no such thing.
double completed_ms(const std::string& said)
{
    constexpr std::string_view kBefore = "completed in ";
    const std::size_t at = said.rfind(kBefore);
    return at == std::string::npos ? 0 : 1e3 * std::atof(said.c_str() + at + kBefore.size());
}

/// Why vdb_render can't show this scene as we do; "" if it can.
std::string other_scene(const Scene& scene, const GridMedium* medium)
{
    if (medium == nullptr)
        return "the scene has no grid";
    if (medium->scale != 1 || medium->translate != glm::dvec3(0))
        return "it can't place a grid";
    if (scene.camera.projection != Camera::Projection::perspective)
        return "the camera is not perspective";
    return "";
}

}  // namespace

std::vector<study::BenchFigure> program_figures(const fs::path& vdb, const Scene& scene,
                                                const std::vector<std::string>& device_words,
                                                const fs::path& folder, int rounds,
                                                std::vector<std::string>& notes)
{
    const write::UnfinishedFile picture(folder / "picture.png");
    const GridMedium* medium = nullptr;
    for (const Medium& m : scene.media)
        if (medium == nullptr)
            medium = std::get_if<GridMedium>(&m);
    std::vector<std::string> own{"/proc/self/exe", "render", vdb.string(), "-o",
                                 picture.path().string()};
    own.insert(own.end(), device_words.begin(), device_words.end());
    std::string refusal = other_scene(scene, medium);
    std::vector<double> own_ms, other_ms, trace_ms;
    for (int round = 0; round < rounds; ++round) {
        const study::ChildResult first = study::run_child(own, folder / "render.log");
        if (first.code != 0) {
            notes.push_back(fmt::format("{}: fumarole render: {}", vdb.filename().string(),
                                        asset::printable(first.said, 200)));
            break;
        }
        own_ms.push_back(1e3 * first.seconds);
        if (!refusal.empty())
            continue;
        const study::ChildResult other = study::run_child(
            vdb_render_words(vdb, scene, *medium, picture.path()), folder / "vdb_render.log");
        if (!other.found) {
            refusal = "not installed: apt-get install libopenvdb-tools";
        } else if (other.code != 0) {
            refusal = asset::printable(other.said, 200);
        } else {
            other_ms.push_back(1e3 * other.seconds);
            trace_ms.push_back(completed_ms(other.said));
        }
    }
    if (!refusal.empty())
        notes.push_back(fmt::format("{}: vdb_render: {}", vdb.filename().string(), refusal));
    std::vector<study::BenchFigure> figures;
    for (const auto& [name, ms] : {std::pair{study::kFirstPicture, &own_ms},
                                   {kVdbRender, &other_ms},
                                   {kVdbRenderTraces, &trace_ms}})
        if (!ms->empty())
            figures.push_back({"programs",
                               vdb.filename().string(),
                               std::string(name),
                               "",
                               0,
                               "time",
                               "ms",
                               study::spread_of(*ms),
                               {480, 270}});
    return figures;
}

}  // namespace fumarole::command
