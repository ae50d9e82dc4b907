#include "asset/scene_transparents.h"

#include <array>
#include <fmt/format.h>

#include "asset/json_writer.h"
#include "asset/scene_ranges.h"
#include "overloaded.h"

namespace fumarole::asset {

namespace {

namespace fs = std::filesystem;

/// In the order of Blend::Kind, but for a pair of factors.
const std::vector<std::string_view>& blend_names()
{
    static const std::vector<std::string_view> names{"alpha", "premultiplied", "add", "multiply"};
    return names;
}

/// In the order of BlendFactor.
const std::vector<std::string_view>& factor_names()
{
    static const std::vector<std::string_view> names{"zero",
                                                     "one",
                                                     "src_color",
                                                     "one_minus_src_color",
                                                     "dst_color",
                                                     "one_minus_dst_color",
                                                     "src_alpha",
                                                     "one_minus_src_alpha",
                                                     "dst_alpha",
                                                     "one_minus_dst_alpha",
                                                     "src_alpha_saturate"};
    return names;
}

Blend read_blend(JsonObject& object)
{
    Blend blend;
    const Json* value = object.find("blend");
    if (value == nullptr || !value->is_object()) {
        blend.kind = static_cast<Blend::Kind>(object.choice("blend", blend_names(), 0));
        return blend;
    }
    JsonObject pair(*value, object.place().key("blend"));
    blend.kind = Blend::Kind::factors;
    blend.source = static_cast<BlendFactor>(pair.need_choice("source", factor_names()));
    blend.destination = static_cast<BlendFactor>(pair.need_choice("destination", factor_names()));
    pair.finish();
    return blend;
}

/// @param may_have_image its kind has a place for one
TransparentLook read_look(JsonObject& object, bool may_have_image, const fs::path& folder)
{
    TransparentLook look;
    look.blend = read_blend(object);
    const bool multiplies = look.blend.kind == Blend::Kind::multiply;
    const bool adds = look.blend.kind == Blend::Kind::add;
    const bool has_radiance = object.read("radiance", kRadiance, look.radiance);
    const bool has_filter = object.read("filter", kFactor, look.filter);
    const bool has_alpha = object.read("alpha", kAlbedo, look.alpha);
    object.read("depth_fade", kLengthOrNone, look.depth_fade);
    bool has_scale = false;
    if (may_have_image) {
        if (object.find("image") != nullptr) {
            object.need_file("image", look.image_file);
            look.image_file = resolved(folder, look.image_file).string();
        }
        has_scale = object.read("scale", kScale, look.scale);
    }
    const JsonPlace& place = object.place();
    object.read("casts", look.casts);
    object.finish();
    if (look.casts && !can_cast(look.blend))
        place.fail("'casts' needs a blend whose 'destination' is no factor of what is behind, "
                   "which light on its way does not have; take \"multiply\" or \"alpha\"");
    const bool image = !look.image_file.empty();
    if (has_scale && !image)
        place.fail("'scale' needs 'image', the picture that it multiplies");
    if (image && (has_radiance || has_filter))
        place.fail(fmt::format("'{}' and 'image' say the same thing: leave one of them out",
                               has_radiance ? "radiance" : "filter"));
    if (has_filter && !multiplies)
        place.fail("'filter' needs \"blend\": \"multiply\"");
    if (has_radiance && multiplies)
        place.fail("'radiance' is of no use to \"blend\": \"multiply\", which has a 'filter'");
    if (has_alpha && !image && (multiplies || adds))
        place.fail(fmt::format("'alpha' is of no use to \"blend\": \"{}\"",
                               blend_names()[static_cast<std::size_t>(look.blend.kind)]));
    return look;
}

void write_look(Members& out, const TransparentLook& look, const fs::path& folder)
{
    const Blend::Kind kind = look.blend.kind;
    if (kind == Blend::Kind::factors) {
        const auto name = [](BlendFactor factor) {
            return factor_names()[static_cast<std::size_t>(factor)];
        };
        out.raw("blend", fmt::format("{{\"source\": \"{}\", \"destination\": \"{}\"}}",
                                     name(look.blend.source), name(look.blend.destination)));
    } else {
        out.raw("blend", fmt::format("\"{}\"", blend_names()[static_cast<std::size_t>(kind)]));
    }
    const bool image = !look.image_file.empty();
    if (image) {
        out.text("image", relative_name(look.image_file, folder));
        out.number("scale", look.scale);
    } else if (kind == Blend::Kind::multiply) {
        out.triple("filter", look.filter);
    } else {
        out.triple("radiance", look.radiance);
    }
    if (image || (kind != Blend::Kind::multiply && kind != Blend::Kind::add))
        out.number("alpha", look.alpha);
    if (look.depth_fade != 0)
        out.number("depth_fade", look.depth_fade);
    if (look.casts)
        out.raw("casts", "true");
}

}  // namespace

Transparent read_transparent(JsonObject object, const fs::path& folder)
{
    switch (object.need_choice("type", {"quad", "billboard", "mesh"})) {
    case 0: {
        QuadTransparent quad;
        object.need("corner", kCoordinate, quad.corner);
        object.need("edges", kCoordinate, quad.edges);
        quad.look = read_look(object, true, folder);
        return quad;
    }
    case 1: {
        BillboardTransparent board;
        object.need("center", kCoordinate, board.center);
        object.need("size", kLength, board.size);
        const JsonPlace place = object.place();
        board.look = read_look(object, true, folder);
        if (board.look.casts)
            place.fail("'casts' is for quads and meshes: a billboard turns with the camera, and "
                       "its shadow would too; take a quad");
        return board;
    }
    default: {
        MeshTransparent mesh;
        object.need_file("file", mesh.file);
        object.read("translate", kCoordinate, mesh.translate);
        object.read("scale", kScale, mesh.scale);
        mesh.look = read_look(object, false, folder);
        mesh.file = resolved(folder, mesh.file).string();
        return mesh;
    }
    }
}

std::string transparent_text(const Transparent& transparent, const std::string& place,
                             const fs::path& folder)
{
    Members out(place);
    std::visit(Overloaded{[&](const QuadTransparent& quad) {
                              out.text("type", "quad");
                              out.triple("corner", quad.corner);
                              out.pair("edges", quad.edges);
                          },
                          [&](const BillboardTransparent& board) {
                              out.text("type", "billboard");
                              out.triple("center", board.center);
                              out.two("size", board.size);
                          },
                          [&](const MeshTransparent& mesh) {
                              out.text("type", "mesh");
                              out.text("file", relative_name(mesh.file, folder));
                              out.triple("translate", mesh.translate);
                              out.number("scale", mesh.scale);
                          }},
               transparent);
    write_look(out, look_of(transparent), folder);
    return out.in_lines(kItemIndent);
}

}  // namespace fumarole::asset
