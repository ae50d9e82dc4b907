#include "transparent/transparent_set.h"

#include <algorithm>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

#include "overloaded.h"
#include <fumarole/errors.h>

namespace fumarole::transparent {

namespace {

Mesh unit_square()
{
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.normals.assign(4, glm::vec3(0, 0, 1));
    mesh.triangles = {0, 1, 2, 0, 2, 3};
    return mesh;
}

/// The rows of a picture, from the bottom as textures have them.
std::vector<glm::vec4> upside_down(const TransparentImage& image)
{
    std::vector<glm::vec4> texels;
    texels.reserve(image.texels.size());
    for (int y = image.height; y-- > 0;) {
        const auto row = image.texels.begin() + static_cast<std::ptrdiff_t>(y) * image.width;
        texels.insert(texels.end(), row, row + image.width);
    }
    return texels;
}

/// A blend as OpenGL's pair of factors, and how its source fades to nothing.
struct BlendState {
    BlendFactor source, destination;
    glm::vec4 faded{0}, fades{1};
};

BlendState blend_state(const TransparentLook& look)
{
    using Kind = Blend::Kind;
    using Factor = BlendFactor;
    switch (look.blend.kind) {
    case Kind::alpha:
        if (look.image == nullptr)
            return {Factor::src_alpha, Factor::one_minus_src_alpha, {}, {0, 0, 0, 1}};
        [[fallthrough]];  // a picture's colours are multiplied by its alpha
    case Kind::premultiplied:
        return {Factor::one, Factor::one_minus_src_alpha};
    case Kind::add:
        return {Factor::one, Factor::one, {}, {1, 1, 1, 0}};
    case Kind::multiply:
        return {Factor::zero, Factor::src_color, glm::vec4(1), {1, 1, 1, 0}};
    case Kind::factors:
        break;
    }
    return {look.blend.source, look.blend.destination, {}, {0, 0, 0, 1}};
}

/// A look's source; of an image, what multiplies that.
glm::vec4 own_source(const TransparentLook& look)
{
    if (look.image != nullptr)  // a filter's is no radiance
        return look.alpha * glm::vec4(glm::vec3(look.scale), 1);
    return {look.blend.kind == Blend::Kind::multiply ? look.filter : look.radiance, look.alpha};
}

bool is_of_destination(BlendFactor factor)
{
    switch (factor) {
    case BlendFactor::dst_color:
    case BlendFactor::one_minus_dst_color:
    case BlendFactor::dst_alpha:
    case BlendFactor::one_minus_dst_alpha:
    case BlendFactor::src_alpha_saturate:
        return true;
    default:
        return false;
    }
}

/// What the colour behind weighs in a factor.
float weight_of_behind(BlendFactor factor)
{
    switch (factor) {
    case BlendFactor::dst_color:
        return 1;
    case BlendFactor::one_minus_dst_color:
        return -1;
    default:
        return 0;
    }
}

/// What a constant, the source's colour and its alpha weigh in a factor.
glm::vec3 own_factor(BlendFactor factor)
{
    switch (factor) {
    case BlendFactor::one:
    case BlendFactor::one_minus_dst_color:
        return {1, 0, 0};
    case BlendFactor::src_color:
        return {0, 1, 0};
    case BlendFactor::one_minus_src_color:
        return {1, -1, 0};
    case BlendFactor::src_alpha:
        return {0, 0, 1};
    case BlendFactor::one_minus_src_alpha:
        return {1, 0, -1};
    default:
        return glm::vec3(0);
    }
}

glm::vec3 weighed(glm::vec3 weights, glm::vec3 color, float alpha)
{
    return weights.x + weights.y * color + weights.z * alpha;
}

/// @param cuts as SeenTransparent has them; what is left is not below 0 anywhere
void set_cuts(shared::TransparentParams& params, const std::vector<glm::vec4>& cuts)
{
    for (int i = 0; i < MAX_CUTS; ++i) {
        const bool is_one = i < static_cast<int>(cuts.size());
        const glm::vec4 cut = is_one ? cuts[static_cast<std::size_t>(i)] : glm::vec4(0, 0, 1, 0);
        params.cut_dx[i / 4][i % 4] = cut.x;
        params.cut_dy[i / 4][i % 4] = cut.y;
        params.cut[i / 4][i % 4] = cut.z;
        params.cut_sign[i / 4][i % 4] = cut.w > 0 ? std::numeric_limits<int>::min() : 0;
    }
}

/// What of `old` was made of `source`, or one made now, noted in `now`.
template <class Held, class Source, class Make>
auto kept_or_made(const std::vector<Held>& old, std::vector<Held>& now, const Source& source,
                  const Make& make)
{
    const auto is_it = [&](const Held& held) { return held.source == source; };
    if (const auto found = std::find_if(now.begin(), now.end(), is_it); found != now.end())
        return found->made;
    const auto before = std::find_if(old.begin(), old.end(), is_it);
    now.push_back(before != old.end() ? *before : Held{source, make(*source)});
    return now.back().made;
}

}  // namespace

glm::vec3 PlainPane::of_source(glm::vec3 color) const
{
    return weighed(own_factor(source_factor), color, source.a);
}

glm::vec3 PlainPane::of_behind(glm::vec3 color) const
{
    return weighed(own_factor(destination_factor), color, source.a);
}

void TransparentSet::set(const std::vector<Transparent>& transparents)
{
    items_.clear();
    listed_ = plain_panes_ = flat_ = quads_ = 0;
    reads_picture_ = false;
    if (transparents.size() > static_cast<std::size_t>(shared::kMostDraws))
        throw Error(fmt::format("Scene::transparents: {} are more than the {} that a fragment's "
                                "key tells apart; join some in one mesh",
                                transparents.size(), shared::kMostDraws));
    if (!transparents.empty() && !has_square_) {
        square_ = {device_, unit_square(), "unit square"};
        has_square_ = true;
    }
    const auto old_meshes = std::exchange(meshes_, {});
    const auto old_images = std::exchange(images_, {});
    for (const Transparent& transparent : transparents) {
        Item item{transparent, nullptr, nullptr};
        const TransparentLook& look = look_of(transparent);
        if (const auto* mesh = std::get_if<MeshTransparent>(&transparent);
            mesh != nullptr && mesh->mesh != nullptr)
            item.mesh = kept_or_made(old_meshes, meshes_, mesh->mesh, [&](const Mesh& source) {
                return std::make_shared<TransparentMesh>(
                    TransparentMesh{{device_, source, "transparent mesh"}, convex_winding(source)});
            });
        if (look.image != nullptr)
            item.image =
                kept_or_made(old_images, images_, look.image, [&](const TransparentImage& source) {
                    auto texture = std::make_shared<gl::Texture>(gl::Texture::make_2d(
                        device_, "transparent image", {source.width, source.height}, GL_RGBA16F,
                        gl::Filter::linear));
                    const std::vector<glm::vec4> texels = upside_down(source);
                    texture->stage(GL_RGBA, GL_FLOAT, texels.data(),
                                   texels.size() * sizeof(glm::vec4));
                    return texture;
                });
        const BlendState state = blend_state(look);
        reads_picture_ = reads_picture_ || is_of_destination(state.source) ||
                         is_of_destination(state.destination);
        items_.push_back(std::move(item));
        SeenTransparent one;
        one.index = items_.size() - 1;
        listed_ += needs_list(one) ? 1 : 0;
        plain_panes_ += plain(one) ? 1 : 0;
        flat_ += is_flat(one) ? 1 : 0;  // billboards are all turned to the eye
        quads_ += std::holds_alternative<QuadTransparent>(transparent) ? 1 : 0;
    }
}

std::vector<light::Caster> TransparentSet::casters() const
{
    std::vector<light::Caster> casters;
    for (const Item& item : items_) {
        const TransparentLook& look = look_of(item.transparent);
        const BlendFactor factor = blend_state(look).destination;
        const bool is_mesh = std::holds_alternative<MeshTransparent>(item.transparent);
        if (!look.casts || factor == BlendFactor::one || (is_mesh && item.mesh == nullptr))
            continue;
        if (!can_cast(look.blend) || std::holds_alternative<BillboardTransparent>(item.transparent))
            throw Error("Scene::transparents: one that casts is a billboard, or has a factor of "
                        "what is behind; take a quad or a mesh, and another blend");
        casters.push_back({world_from_object(item, {}),
                           item.mesh ? &item.mesh->triangles : &square_,
                           item.image ? item.image->view() : gl::TextureView{}, own_source(look),
                           static_cast<std::uint32_t>(factor),
                           look.blend.kind == Blend::Kind::multiply, is_mesh});
    }
    return casters;
}

glm::dmat4 TransparentSet::world_from_object(const Item& item, const Eye& eye) const
{
    const auto square = [](glm::dvec3 corner, glm::dvec3 across, glm::dvec3 up) {
        return glm::dmat4(glm::dvec4(across, 0), glm::dvec4(up, 0), glm::dvec4(0),
                          glm::dvec4(corner, 1));
    };
    return std::visit(
        Overloaded{[&](const QuadTransparent& quad) {
                       return square(quad.corner, quad.edges[0], quad.edges[1]);
                   },
                   [&](const BillboardTransparent& board) {
                       const glm::dvec3 across = board.size.x * eye.world_from_view[0];
                       const glm::dvec3 up = board.size.y * eye.world_from_view[1];
                       return square(board.center - (across + up) / 2.0, across, up);
                   },
                   [&](const MeshTransparent& mesh) {
                       return glm::scale(glm::translate(glm::dmat4(1.0), mesh.translate),
                                         glm::dvec3(mesh.scale));
                   }},
        item.transparent);
}

SeenTransparents TransparentSet::look(const PreparedFrame& frame) const
{
    constexpr double kFar = std::numeric_limits<double>::infinity();
    SeenTransparents all;
    all.view_z = {kFar, -kFar};
    const glm::dvec2 size(frame.picture_size);
    for (std::size_t i = 0; i < items_.size(); ++i) {
        const Item& item = items_[i];
        const bool is_mesh = std::holds_alternative<MeshTransparent>(item.transparent);
        if (is_mesh && item.mesh == nullptr)
            continue;
        SeenTransparent seen;
        seen.index = i;
        seen.world_from_object = world_from_object(item, frame.eye);
        const Bounds& bounds = is_mesh ? item.mesh->triangles.bounds() : square_.bounds();
        seen.view_z = {kFar, -kFar};
        seen.area = {glm::dvec2(kFar), glm::dvec2(-kFar)};
        bool crosses = false;  // the near plane: it may be anywhere in the picture
        for (int k = 0; k < 8; ++k) {
            const glm::dvec4 view = frame.host.view_from_world * seen.world_from_object *
                                    glm::dvec4(bounds.corner(k), 1.0);
            seen.view_z = {std::min(seen.view_z.x, -view.z), std::max(seen.view_z.y, -view.z)};
            const glm::dvec4 clip = frame.host.clip_from_view * view;
            if (!(-view.z > frame.eye.near) || !(clip.w > 0)) {
                crosses = true;
                continue;
            }
            const glm::dvec2 pixel = (glm::dvec2(clip) / clip.w * 0.5 + 0.5) * size;
            seen.area.low = glm::min(seen.area.low, pixel);
            seen.area.high = glm::max(seen.area.high, pixel);
        }
        if (crosses)
            seen.area = {glm::dvec2(0), size};
        if (!(seen.view_z.y > frame.eye.near && seen.view_z.x < frame.eye.far) && !frame.prepares)
            continue;
        all.view_z = {std::min(all.view_z.x, seen.view_z.x), std::max(all.view_z.y, seen.view_z.y)};
        const bool in_picture = glm::all(glm::lessThan(seen.area.low, size)) &&
                                glm::all(glm::greaterThan(seen.area.high, glm::dvec2(0)));
        if (in_picture || frame.prepares)
            all.list.push_back(seen);
    }
    std::stable_sort(
        all.list.begin(), all.list.end(),
        [](const SeenTransparent& a, const SeenTransparent& b) { return a.view_z.x < b.view_z.x; });
    return all;
}

bool TransparentSet::needs_list(const SeenTransparent& seen) const
{
    const Item& item = items_[seen.index];
    const BlendState state = blend_state(look_of(item.transparent));
    return (item.mesh != nullptr && item.mesh->winding == Winding::none) ||
           (is_of_destination(state.source) && weight_of_behind(state.source) == 0) ||
           is_of_destination(state.destination);
}

float TransparentSet::of_behind(const SeenTransparent& seen) const
{
    return weight_of_behind(blend_state(look_of(items_[seen.index].transparent)).source);
}

bool TransparentSet::is_flat(const SeenTransparent& seen) const
{
    return items_[seen.index].mesh == nullptr;
}

glm::dmat4 TransparentSet::world_from_box(const SeenTransparent& seen) const
{
    if (is_flat(seen))
        return seen.world_from_object;
    const Bounds& bounds = items_[seen.index].mesh->triangles.bounds();
    return glm::scale(glm::translate(seen.world_from_object, bounds.min), bounds.max - bounds.min);
}

std::optional<PlainPane> TransparentSet::plain(const SeenTransparent& seen) const
{
    const Item& item = items_[seen.index];
    const TransparentLook& look = look_of(item.transparent);
    const BlendState state = blend_state(look);
    if (!is_flat(seen) || needs_list(seen) || look.image != nullptr || fades(seen) ||
        of_behind(seen) != 0)
        return {};
    return PlainPane{own_source(look), state.source, state.destination};
}

shared::TransparentParams TransparentSet::params(const SeenTransparent& seen,
                                                 const PreparedFrame& frame) const
{
    const TransparentLook& look = look_of(items_[seen.index].transparent);
    const BlendState state = blend_state(look);
    const glm::dmat4 view_from_eye(glm::transpose(frame.eye.world_from_view));
    const glm::dmat4 view_from_object = view_from_eye *
                                        glm::translate(glm::dmat4(1.0), -frame.eye.position) *
                                        seen.world_from_object;
    shared::TransparentParams params{};
    params.clip_from_object = glm::mat4(frame.host.clip_from_view * view_from_object);
    params.view_z_from_object = glm::vec4(-glm::transpose(view_from_object)[2]);
    const bool filters = look.blend.kind == Blend::Kind::multiply;
    params.source = own_source(look);
    params.faded = state.faded;
    params.fades = state.fades;
    params.of_source = own_factor(state.source);
    params.of_behind = own_factor(state.destination);
    params.view_z = glm::vec2(frame.eye.near, frame.eye.far);
    params.inverse_depth_fade = fades(seen) ? 1 / look.depth_fade : 0.0f;
    params.key = shared::fragment_key(static_cast<std::uint32_t>(seen.index),
                                      static_cast<std::uint32_t>(state.source),
                                      static_cast<std::uint32_t>(state.destination));
    params.is_filter = filters ? 1 : 0;
    params.pane = seen.pane;
    set_cuts(params, seen.cuts);
    return params;
}

bool TransparentSet::fades(const SeenTransparent& seen) const
{
    return look_of(items_[seen.index].transparent).depth_fade > 0;
}

gl::TextureView TransparentSet::image(const SeenTransparent& seen) const
{
    const Item& item = items_[seen.index];
    return item.image != nullptr ? item.image->view() : gl::TextureView{};
}

void TransparentSet::draw(const SeenTransparent& seen) const
{
    const Item& item = items_[seen.index];
    (item.mesh != nullptr ? item.mesh->triangles : square_).draw(device_);
}

void TransparentSet::draw_in_order(const SeenTransparent& seen, const PreparedFrame& frame) const
{
    if (is_flat(seen)) {
        draw(seen);
        return;
    }
    // What a picture mirrors winds the other way in it.
    const glm::dmat4& clip = frame.host.clip_from_view;
    const double turned = (clip[0][0] * clip[1][1] - clip[1][0] * clip[0][1]) *
                          glm::determinant(glm::dmat3(frame.host.view_from_world));
    const bool winds_left = items_[seen.index].mesh->winding == Winding::counter_clockwise;
    device_->FrontFace(winds_left == (turned > 0) ? GL_CCW : GL_CW);
    device_->Enable(GL_CULL_FACE);
    for (const GLenum away : {GL_FRONT, GL_BACK}) {
        device_->CullFace(away);
        draw(seen);
    }
    device_->Disable(GL_CULL_FACE);
}

}  // namespace fumarole::transparent
