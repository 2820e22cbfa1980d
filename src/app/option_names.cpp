// What values of enumerations are called on the command line and in files.
#include "app/options.h"

namespace irradia::app {

const Names<Method>& method_names() {
    static const Names<Method> names = {{Method::irradiance, "irradiance"},
                                        {Method::radiance, "radiance"},
                                        {Method::gather, "gather"},
                                        {Method::path, "path"}};
    return names;
}
const Names<GradientRule>& gradient_names() {
    static const Names<GradientRule> names = {
        {GradientRule::none, "none"}, {GradientRule::ward, "ward"}, {GradientRule::crease, "crease"}};
    return names;
}
const Names<RadiusRule>& radius_names() {
    static const Names<RadiusRule> names = {
        {RadiusRule::harmonic, "harmonic"}, {RadiusRule::minimum, "minimum"}, {RadiusRule::hessian, "hessian"}};
    return names;
}
const Names<WeightRule>& weight_names() {
    static const Names<WeightRule> names = {
        {WeightRule::ward, "ward"}, {WeightRule::tabellion, "tabellion"}, {WeightRule::cubic, "cubic"}};
    return names;
}
const Names<GlossyRule>& glossy_names() {
    static const Names<GlossyRule> names = {{GlossyRule::automatic, "auto"},
                                            {GlossyRule::samples, "samples"},
                                            {GlossyRule::harmonics, "harmonics"},
                                            {GlossyRule::traced, "traced"}};
    return names;
}
const Names<DirectMis>& direct_mis_names() {
    static const Names<DirectMis> names = {
        {DirectMis::automatic, "auto"}, {DirectMis::on, "on"}, {DirectMis::off, "off"}};
    return names;
}
const Names<Quality>& quality_names() {
    static const Names<Quality> names = {
        {Quality::draft, "draft"}, {Quality::medium, "medium"}, {Quality::fine, "fine"}, {Quality::finest, "finest"}};
    return names;
}

}  // namespace irradia::app
