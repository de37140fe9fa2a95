//! The OpenAPI document, made from the table of routes.

use crate::web::{Kind, Need, Route, route::Shape};
use axum::http::Method;
use std::collections::BTreeMap;
use utoipa::openapi::path::{HttpMethod, OperationBuilder, Parameter, ParameterBuilder, ParameterIn};
use utoipa::openapi::request_body::RequestBodyBuilder;
use utoipa::openapi::schema::{ObjectBuilder, Type};
use utoipa::openapi::security::{HttpAuthScheme, HttpBuilder, SecurityRequirement, SecurityScheme};
use utoipa::openapi::{
    ComponentsBuilder, ContentBuilder, InfoBuilder, OpenApi, OpenApiBuilder, PathItem, PathsBuilder, RefOr,
    Required, ResponseBuilder, Schema,
};

/// The document of these routes.
pub(super) fn describe(routes: &[Route]) -> OpenApi {
    let mut schemas: BTreeMap<String, RefOr<Schema>> = BTreeMap::new();
    let mut items: BTreeMap<&str, PathItem> = BTreeMap::new();
    for route in routes.iter().filter(|route| route.kind != Kind::Page && route.path.starts_with("/api/")) {
        for (name, schema, parts) in route.takes.iter().chain(&route.gives) {
            schemas.extend(parts.iter().cloned());
            schemas.insert(name.clone(), schema.clone());
        }
        let item = PathItem::new(method(&route.method), operation(route));
        match items.entry(route.path) {
            std::collections::btree_map::Entry::Vacant(entry) => {
                entry.insert(item);
            }
            std::collections::btree_map::Entry::Occupied(mut entry) => entry.get_mut().merge_operations(item),
        }
    }
    let bearer = SecurityScheme::Http(HttpBuilder::new().scheme(HttpAuthScheme::Bearer).build());
    let components = schemas
        .into_iter()
        .fold(ComponentsBuilder::new(), |components, (name, schema)| components.schema(name, schema));
    let paths = items.into_iter().fold(PathsBuilder::new(), |paths, (path, item)| paths.path(path, item));
    let about = "Telemetry, history and control of a fleet. Times are microseconds since 1970 UTC, angles radians, \
                 lengths metres, unless a name says otherwise.";
    OpenApiBuilder::new()
        .info(
            InfoBuilder::new()
                .title("Lutra")
                .version(env!("CARGO_PKG_VERSION"))
                .description(Some(about))
                .build(),
        )
        .paths(paths.build())
        .components(Some(components.security_scheme("token", bearer).build()))
        .security(Some([SecurityRequirement::new("token", Vec::<String>::new())]))
        .build()
}

fn operation(route: &Route) -> OperationBuilder {
    let media = route.media.unwrap_or("application/json");
    let content = |shape: &Shape| ContentBuilder::new().schema(Some(reference(shape))).build();
    let mut good = ResponseBuilder::new().description("As asked.");
    good = match &route.gives {
        Some(shape) => good.content(media, content(shape)),
        None if route.media.is_some() => good.content(media, ContentBuilder::new().build()),
        None => good,
    };
    let mut operation = OperationBuilder::new()
        .summary(Some(route.about))
        .description(Some(needs(route.need)))
        .operation_id(Some(identifier(route)))
        .response("200", good);
    for (status, text) in [
        ("400", "Malformed."),
        ("401", "Not logged in."),
        ("403", "Not allowed."),
        ("422", "Refused, with the reason."),
    ] {
        operation = operation.response(status, ResponseBuilder::new().description(text));
    }
    let other = "Something else; like all of these with a code, and a text that says what to do.";
    operation = operation.response("default", ResponseBuilder::new().description(other));
    if let Some(shape) = &route.takes {
        let body = RequestBodyBuilder::new().content("application/json", content(shape));
        operation = operation.request_body(Some(body.required(Some(Required::True)).build()));
    }
    if route.takes_file {
        let body =
            RequestBodyBuilder::new().content("application/octet-stream", ContentBuilder::new().build());
        operation = operation.request_body(Some(body.required(Some(Required::True)).build()));
    }
    let in_path = route.path.split('/').filter_map(|part| part.strip_prefix('{')?.strip_suffix('}'));
    for name in in_path {
        operation = operation.parameter(path_parameter(name));
    }
    route.query.iter().fold(operation, |operation, parameter| operation.parameter(parameter.clone()))
}

fn path_parameter(name: &str) -> Parameter {
    let schema = ObjectBuilder::new().schema_type(Type::Integer).minimum(Some(0)).build();
    let parameter =
        ParameterBuilder::new().name(name).parameter_in(ParameterIn::Path).required(Required::True);
    parameter.schema(Some(schema)).build()
}

/// `Vec<T>` and the like have no name and are inlined.
fn reference((name, schema, _): &Shape) -> RefOr<Schema> {
    match schema {
        RefOr::T(Schema::Array(_)) => schema.clone(),
        _ => RefOr::Ref(utoipa::openapi::Ref::from_schema_name(name)),
    }
}

fn identifier(route: &Route) -> String {
    let path = route.path.trim_start_matches("/api/").replace(['{', '}'], "").replace(['/', '.'], "_");
    format!("{}_{path}", route.method.as_str().to_lowercase())
}

fn needs(need: Need) -> String {
    match need {
        Need::Anyone => "For anyone.".to_owned(),
        Need::Session => "For browsers that are logged in.".to_owned(),
        Need::Account => "For everyone who is logged in, also without a role.".to_owned(),
        Need::Somewhere(role) => {
            format!("Needs the role {role} on some vessel; shows what the remote may see.")
        }
        Need::OnVessel(role) => format!("Needs the role {role} on the vessel."),
        Need::Everywhere(role) => format!("Needs the role {role} on all vessels."),
        Need::Figures => "For this machine, or an admin.".to_owned(),
        Need::Link => "For a vessel with the token of its link.".to_owned(),
    }
}

fn method(method: &Method) -> HttpMethod {
    match *method {
        Method::POST => HttpMethod::Post,
        Method::PUT => HttpMethod::Put,
        Method::DELETE => HttpMethod::Delete,
        Method::PATCH => HttpMethod::Patch,
        _ => HttpMethod::Get,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reference_leads_somewhere() {
        let document = serde_json::to_value(describe(&crate::http::routes::table())).unwrap();
        let text = document.to_string();
        let mut count = 0;
        for part in text.split("\"$ref\":\"#/components/schemas/").skip(1) {
            let name = part.split('"').next().unwrap();
            assert!(document["components"]["schemas"].get(name).is_some(), "{name} is nowhere");
            count += 1;
        }
        assert!(count > 3 && document["paths"]["/api/v1/tokens"]["post"]["requestBody"].is_object());
    }
}
