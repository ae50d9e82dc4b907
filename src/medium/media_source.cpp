#include "medium/media_source.h"

#include <algorithm>
#include <fmt/format.h>

namespace fumarole::medium {

namespace {

using Profile = MediumSource::Profile;
using Depth = MediumSource::Depth;

class Writer {
public:
    Writer(const std::vector<GridSource>& grids, const std::vector<MediumSource>& media,
           bool colored_extinction)
        : grids_{grids}, media_{media}, channels_{colored_extinction ? "rgb" : "a"}
    {
    }

    std::string text()
    {
        write("// A colour's share in extinction: its rgb, or its mean in alpha.\n"
              "extinction_t extinction_of(vec4 color)\n{{\n    return color.{};\n}}\n\n",
              channels_);
        if (std::any_of(media_.begin(), media_.end(),
                        [](const MediumSource& medium) { return medium.temperature >= 0; }))
            write("#include \"lib/blackbody.glsl\"\n\n");
        for (std::size_t k = 0; k < grids_.size(); ++k)
            textures(k);
        held();
        for (std::size_t m = 0; m < media_.size(); ++m)
            medium(m, media_[m]);
        sums();
        return std::move(out_);
    }

private:
    template <typename... T> void write(fmt::format_string<T...> format, T&&... arguments)
    {
        fmt::format_to(std::back_inserter(out_), format, std::forward<T>(arguments)...);
    }

    void textures(std::size_t k)
    {
        write("layout(binding = GRID_UNIT + {0}) uniform sampler3D u_grid_{0}_tx;\n", k);
        if (grids_[k].kind != GridSource::Kind::dense)
            write("layout(binding = GRID_UNIT + {}) uniform usampler3D u_page_{}_tx;\n",
                  grids_.size() + k, k);
    }

    void held()
    {
        write("\nHeldMedia held_media()\n{{\n    HeldMedia held;\n");
        for (std::size_t k = 0; k < grids_.size(); ++k)
            write("    held.grids[{0}] = u_media.grids[{0}];\n", k);
        for (std::size_t m = 0; m < media_.size(); ++m)
            write("    held.media[{0}] = u_media.media[{0}];\n", m);
        write("    return held;\n}}\n");
    }

    /// The value of grid k at a MediaPoint `at`.
    [[nodiscard]] std::string lookup(int k) const
    {
        const GridSource& grid = grids_[static_cast<std::size_t>(k)];
        const char* channels = grid.color ? "rgb" : "r";
        if (grid.kind == GridSource::Kind::dense)
            return fmt::format("sample_dense(u_grid_{0}_tx, at.held.grids[{0}], at.q[{0}]).{1}", k,
                               channels);
        return fmt::format(
            "sample_{2}(u_grid_{0}_tx, u_page_{0}_tx, at.held.grids[{0}], at.q[{0}]).{1}", k,
            channels, grid.kind == GridSource::Kind::tree ? "tree" : "bricks");
    }

    /// What its coefficients are multiplied by at a MediaPoint `at`.
    [[nodiscard]] std::string density(std::size_t m, const MediumSource& medium) const
    {
        if (medium.density >= 0 && medium.is_box)  // its grid goes on for a voxel past the faces
            return fmt::format("inside_bounds(at.held.media[{}], at.p) ? {} : 0.0", m,
                               lookup(medium.density));
        if (medium.density >= 0)
            return lookup(medium.density);
        switch (medium.profile) {
        case Profile::exp_height:
            return fmt::format("profile_exp_height(at.held.media[{}], at.p)", m);
        case Profile::noise:
            return fmt::format("profile_noise({}, at.p)", m);
        default:
            return fmt::format("profile_homogeneous(at.held.media[{}], at.p)", m);
        }
    }

    [[nodiscard]] const char* density_type(const MediumSource& medium) const
    {
        const bool color = medium.density >= 0 && !medium.is_box &&
                           grids_[static_cast<std::size_t>(medium.density)].color;
        return color ? "vec3" : "float";
    }

    /// What it emits at a MediaPoint `at`, where its `medium` and `density` are known.
    [[nodiscard]] std::string emission(const MediumSource& medium) const
    {
        std::string sum;
        if (medium.glows)
            sum = fmt::format("medium.emission * ({})",
                              medium.emission >= 0 ? lookup(medium.emission) : "density");
        if (medium.temperature >= 0)
            sum += fmt::format("{}medium.blackbody * blackbody(medium.kilokelvin_per_unit * {})",
                               sum.empty() ? "" : " + ", lookup(medium.temperature));
        return sum.empty() ? "vec3(0.0)" : sum;
    }

    void medium(std::size_t m, const MediumSource& medium)
    {
        const char* type = density_type(medium);
        write("\n{} medium_{}_density(MediaPoint at)\n{{\n    return {};\n}}\n", type, m,
              density(m, medium));
        write("\nMediumSample medium_{0}(MediaPoint at)\n{{\n"
              "    MediumParams medium = at.held.media[{0}];\n"
              "    {1} density = medium_{0}_density(at);\n"
              "    return MediumSample(medium.sigma_s * density{2}, "
              "extinction_t(medium.sigma_t.{3} * "
              "density),\n                        {4}, medium.g);\n}}\n",
              m, type, medium.tint >= 0 ? fmt::format(" * ({})", lookup(medium.tint)) : "",
              channels_, emission(medium));
        write("\nvec2 medium_{0}_segment(vec3 p, vec3 d, float begin, float end)\n{{\n"
              "    return {1}_segment(u_media.media[{0}], p, d, begin, end);\n}}\n",
              m, medium.is_box ? "box" : "grid");
        if (medium.depth == Depth::closed)
            closed_depth(m, medium);
        else if (medium.depth == Depth::marched && medium.islands)
            islands_depth(m, type);
        else if (medium.depth == Depth::marched)
            marched_depth(m, type);
    }

    void closed_depth(std::size_t m, const MediumSource& medium)
    {
        write("\nextinction_t medium_{0}_depth(vec3 p, vec3 wi, float range)\n{{\n"
              "    vec2 t = shadow_segment(medium_{0}_segment(p, wi, 0.0, range), range);\n"
              "    if (!(t.x < t.y))\n        return extinction_t(0.0);\n"
              "    return u_media.media[{0}].sigma_t.{1} * {2};\n}}\n",
              m, channels_,
              medium.profile == Profile::exp_height
                  ? fmt::format("exp_height_depth(u_media.media[{}], p, wi, t)", m)
                  : std::string("(t.y - t.x)"));
    }

    void marched_depth(std::size_t m, const char* type)
    {
        write("\nextinction_t medium_{0}_depth(vec3 p, vec3 wi, float range, int steps)\n{{\n"
              "    vec2 t = shadow_segment(medium_{0}_segment(p, wi, 0.0, range), range);\n"
              "    if (!(t.x < t.y))\n        return extinction_t(0.0);\n"
              "    {1} sum = {1}(0.0);\n"
              "    float ds = (t.y - t.x) / float(steps);\n"
              "    HeldMedia held = held_media();\n"
              "    for (int j = 0; j < steps; ++j) {{\n"
              "        count_sample();\n"
              "        sum += medium_{0}_density(media_point(p + wi * (t.x + (float(j) + 0.5) * "
              "ds), held));\n    }}\n"
              "    return u_media.media[{0}].sigma_t.{2} * sum * ds;\n}}\n",
              m, type, channels_);
    }

    void islands_depth(std::size_t m, const char* type)
    {
        write("\nextinction_t medium_{0}_depth(vec3 p, vec3 wi, float range, int steps)\n{{\n"
              "    {1} sum = {1}(0.0);\n"
              "    HeldMedia held = held_media();\n"
              "    for (int i = 0; i < u_media.island_count; ++i) {{\n"
              "        if (u_media.islands[i].medium != {0})\n            continue;\n"
              "        vec2 t = island_segment(u_media.islands[i], p, wi, 0.0, range);\n"
              "        if (!(t.x < t.y))\n            continue;\n"
              "        float ds = (t.y - t.x) / float(steps);\n"
              "        for (int j = 0; j < steps; ++j) {{\n"
              "            count_sample();\n"
              "            sum += ds * medium_{0}_density(media_point(p + wi * (t.x + (float(j) + "
              "0.5) * ds), held));\n        }}\n    }}\n"
              "    return u_media.media[{0}].sigma_t.{2} * sum;\n}}\n",
              m, type, channels_);
    }

    /// A function whose body has a line for each medium whose depth is found so.
    template <typename Line>
    void sum(const char* head, const char* first, bool all, Depth depth, const char* last,
             const Line& line)
    {
        write("\n{}\n{{\n{}", head, first);
        for (std::size_t m = 0; m < media_.size(); ++m)
            if (all || media_[m].depth == depth)
                out_ += line(m);
        write("{}}}\n", last);
    }

    void sums()
    {
        sum("void add_media(inout MediumSample sum, inout vec2 phase, MediaPoint at)", "", true,
            Depth::none, "", [](std::size_t m) {
                return fmt::format("    add_medium(sum, phase, medium_{}(at));\n", m);
            });
        sum("// Where p + t d, t in [begin, end], can meet a medium at all.\n"
            "vec2 media_segment(vec3 p, vec3 d, float begin, float end)",
            "    vec2 all_media = vec2(end, begin);\n", true, Depth::none,
            "    return all_media;\n", [](std::size_t m) {
                return fmt::format(
                    "    add_segment(all_media, medium_{}_segment(p, d, begin, end));\n", m);
            });
        const char* zero = "    extinction_t sum = extinction_t(0.0);\n";
        const char* end = "    return sum;\n";
        sum("// Optical depth from p along wi over `range` metres of the media that have a closed "
            "form.\nextinction_t closed_depth(vec3 p, vec3 wi, float range)",
            zero, false, Depth::closed, end, [](std::size_t m) {
                return fmt::format("    sum += medium_{}_depth(p, wi, range);\n", m);
            });
        sum("// What of it dims a light that the media scatter.\n"
            "extinction_t closed_dimming(vec3 p, vec3 wi, float range)",
            zero, false, Depth::closed, end, [](std::size_t m) {
                return fmt::format("    sum += u_media.media[{0}].light_dimming * "
                                   "medium_{0}_depth(p, wi, range);\n",
                                   m);
            });
        sum("// Of the others.\n"
            "extinction_t marched_depth(vec3 p, vec3 wi, float range, int steps)",
            zero, false, Depth::marched, end, [](std::size_t m) {
                return fmt::format("    sum += medium_{}_depth(p, wi, range, steps);\n", m);
            });
        sum("// Their extinction [1/m].\n"
            "extinction_t marched_extinction(vec3 p, HeldMedia held)",
            "    extinction_t sum = extinction_t(0.0);\n"
            "    MediaPoint at = media_point(p, held);\n",
            false, Depth::marched, end, [&](std::size_t m) {
                return fmt::format(
                    "    sum += at.held.media[{0}].sigma_t.{1} * medium_{0}_density(at);\n", m,
                    channels_);
            });
    }

    const std::vector<GridSource>& grids_;
    const std::vector<MediumSource>& media_;
    const char* channels_;  ///< channels of a colour with its mean in alpha
    std::string out_;
};

}  // namespace

std::string write_media(const std::vector<GridSource>& grids,
                        const std::vector<MediumSource>& media, bool colored_extinction)
{
    return Writer(grids, media, colored_extinction).text();
}

}  // namespace fumarole::medium
