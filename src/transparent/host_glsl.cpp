#include <fumarole/host_glsl.h>

#include <cctype>
#include <fmt/format.h>
#include <set>
#include <string_view>

#include "gl/program.h"
#include "shared/volume_at_params.h"

namespace fumarole {

namespace {

bool is_of_name(char c)
{
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

/// The last name in a text, where that ends with anything.
std::string_view last_name(std::string_view text)
{
    while (!text.empty() && !is_of_name(text.back()))
        text.remove_suffix(1);
    std::size_t begin = text.size();
    while (begin > 0 && is_of_name(text[begin - 1]))
        --begin;
    return text.substr(begin);
}

std::string_view text_before(std::string_view text, std::string_view end)
{
    return text.substr(0, text.find(end));
}

using Names = std::set<std::string, std::less<>>;

/// What a line declares for all that follow. Our files keep the bodies of functions and of structs
/// indented, and write a block's one member on its line.
void add_declared(std::string_view line, Names& names)
{
    for (const std::string_view directive : {"#define ", "#ifdef ", "#ifndef "})
        if (line.starts_with(directive)) {
            line.remove_prefix(directive.size());
            std::size_t end = 0;
            while (end < line.size() && is_of_name(line[end]))
                ++end;
            names.emplace(line.substr(0, end));
            return;
        }
    if (line.empty() || std::isalpha(static_cast<unsigned char>(line[0])) == 0)
        return;
    const bool in_layout = line.starts_with("layout(");
    if (in_layout)
        line.remove_prefix(line.find(')') + 1);
    if (in_layout || line.starts_with("struct ")) {
        names.emplace(last_name(text_before(line, line.find('{') != line.npos ? "{" : ";")));
        if (in_layout && line.find('{') != line.npos)
            names.emplace(
                last_name(text_before(text_before(line.substr(line.find('{')), ";"), "[")));
    } else if (line.starts_with("const ")) {
        names.emplace(last_name(text_before(line, " = ")));
    } else if (line.find('(') != line.npos) {
        names.emplace(last_name(text_before(line, "(")));
    }
}

std::string with_prefix(std::string_view name)
{
    for (const char c : name)
        if (std::islower(static_cast<unsigned char>(c)) != 0)
            return fmt::format("fumarole_{}", name);
    return fmt::format("FUMAROLE_{}", name);
}

/// A text in which all that it declares has a name of ours.
std::string with_names_of_ours(std::string_view text)
{
    Names names;
    for (std::string_view rest = text; !rest.empty();) {
        const std::string_view line = text_before(rest, "\n");
        add_declared(line, names);
        rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    }
    std::string out;
    for (std::size_t i = 0; i < text.size();) {
        std::size_t end = i + 1;
        if (text.substr(i).starts_with("//"))
            end = std::min(text.find('\n', i), text.size());
        else if (is_of_name(text[i]))
            while (end < text.size() && is_of_name(text[end]))
                ++end;
        const std::string_view token = text.substr(i, end - i);
        const bool is_member = i > 0 && text[i - 1] == '.';
        if (!is_member && names.contains(token))
            out += with_prefix(token);
        else
            out += token;
        i = end;
    }
    return out;
}

/// A file of glsl/host with all that it needs.
/// @param bindings of it, as lines
std::string host_text(std::string_view file, const std::string& bindings, gl::Defines variant)
{
    variant.add_file("shared/bindings.h", bindings);
    variant.add_file("shared/types.h", "#define FUM_SHARED_BEGIN\n#define FUM_SHARED_END\n"
                                       "#define FUM_SHARED_FUNCTION\n#define FUM_STD140\n");
    std::string text = gl::expand_shader(file, variant).text;
    text.erase(0, text.find('\n') + 1);  // the host's shader has a version
    return with_names_of_ours(text);
}

}  // namespace

std::string volume_at_glsl(const VolumeAtBindings& bindings)
{
    const std::uint32_t unit = bindings.first_unit;
    return host_text(
        "host/volume_at.glsl",
        fmt::format("#define VOLUME_AT_BLOCK {}\n"
                    "#define INTEGRATED_SCATTERING_UNIT {}\n"
                    "#define INTEGRATED_TRANSMITTANCE_UNIT {}\n"
                    "#define LAYER_DEPTH_UNIT {}\n"
                    "#define SPLIT_SCATTERING_UNIT {}\n"
                    "#define SPLIT_TRANSMITTANCE_UNIT {}\n",
                    bindings.block, unit, unit + 1, unit + 2, unit + 3, unit + 4),
        {{"kLayerScale", "u_volume_at.layer_scale"},
         {"kMonochrome", fmt::format("u_volume_at.transmittance == {}", VOLUME_AT_GREY)},
         {"kExtinctionInAlpha", fmt::format("u_volume_at.transmittance == {}", VOLUME_AT_GREY)},
         {"kRedInAlpha", fmt::format("u_volume_at.transmittance == {}", VOLUME_AT_RED_IN_ALPHA)},
         {"kTricubic", "u_volume_at.tricubic != 0"}});
}

std::string transparent_glsl(const TransparentBindings& bindings)
{
    return host_text("host/transparent.glsl",
                     fmt::format("#define TRANSPARENT_BLOCK {}\n"
                                 "#define SCENE_DEPTH_UNIT {}\n"
                                 "#define FRAGMENT_LISTS_IMAGE {}\n"
                                 "#define FRAGMENT_COUNT_BUFFER {}\n"
                                 "#define FRAGMENTS_BUFFER {}\n",
                                 bindings.block, bindings.depth_unit, bindings.lists_image,
                                 bindings.first_buffer, bindings.first_buffer + 1),
                     {{"kHalfColor", "u_transparent.half_color != 0u"}});
}

}  // namespace fumarole
