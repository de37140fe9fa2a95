//! The view of detections in the database: made, and replaced when a later version of Lutra defines it differently.

use super::super::trouble::{is_answer, is_of_columns, is_of_the_moment};
use super::super::views;
use super::{Session, Trouble, patiently};
use sqlx::AssertSqlSafe;

impl Session {
    /// Makes the view of detections as this version of Lutra has it, or leaves the one that is so already.
    pub(super) async fn make_view(&mut self, postgis: Option<&str>) -> Result<(), Trouble> {
        const VIEW: &str = "SELECT c.relkind::text, coalesce(obj_description(c.oid, 'pg_class'), '') FROM pg_class c \
                            JOIN pg_namespace n ON n.oid = c.relnamespace WHERE n.nspname = $1 AND c.relname = 'detections'";
        let asked = sqlx::query_as(VIEW).bind(&self.schema).fetch_optional(&mut self.connection);
        let there: Option<(String, String)> = patiently(asked).await?;
        // A table of that name is a person's own, and so is a view without Lutra's comment.
        if let Some((kind, comment)) = &there
            && (kind != "v" || !comment.starts_with(views::OWN))
        {
            tracing::warn!(
                "PostgreSQL: Lutra did not make {}.detections, so it stays as it is; rename it, and the next connection makes the \
                 view of detections",
                self.schema
            );
            return Ok(());
        }
        let has_geometry = self.there.get("detections").is_some_and(|columns| columns.contains_key("place"));
        for postgis in [postgis, None].into_iter().skip(usize::from(postgis.is_none())) {
            let view = views::detections(&self.schema, postgis);
            if there.as_ref().is_some_and(|(_, comment)| comment.contains(&views::mark(&view))) {
                return Ok(());
            }
            match self.replace_view(&view).await {
                // Only where PostGIS cannot be used, and no view has a place that would be lost: an attempt that failed by chance is made
                // again by the next connection.
                Err(Trouble::Sql(error))
                    if is_answer(&error)
                        && postgis.is_some()
                        && !has_geometry
                        && !is_of_the_moment(&error) =>
                {
                    tracing::warn!("PostgreSQL: the view detections has no geometry: {error}");
                }
                // What is recorded goes on without it.
                Err(Trouble::Sql(error)) if is_answer(&error) && there.is_some() => {
                    self.say_that_the_view_stays(&error);
                    return Ok(());
                }
                done => return done,
            }
        }
        Ok(())
    }

    fn say_that_the_view_stays(&self, error: &sqlx::Error) {
        let remedy = if is_of_the_moment(error) {
            "the next connection tries again".to_owned()
        } else {
            format!(
                "drop {}.detections with all that depends on it, and the next connection makes it again",
                self.schema
            )
        };
        tracing::warn!(
            "PostgreSQL: the view detections stays as an earlier version of Lutra made it: {error}; {remedy}"
        );
    }

    /// Makes a view, or another in its place, with the rights that the old one gave, all or nothing.
    async fn replace_view(&mut self, view: &str) -> Result<(), Trouble> {
        let comment = views::comment(&self.schema, view);
        // This keeps rights and views over it, and takes columns that are added at the end.
        let replaced = self.at_once(&format!("{view}; {comment}")).await;
        if !matches!(&replaced, Err(Trouble::Sql(error)) if is_of_columns(error)) {
            return replaced;
        }
        let name = format!("\"{}\".detections", self.schema);
        let rights = AssertSqlSafe(format!(
            "SELECT 'GRANT ' || a.privilege_type || ' ON {name} TO ' || coalesce(quote_ident(r.rolname), 'PUBLIC') \
             || CASE WHEN a.is_grantable THEN ' WITH GRANT OPTION' ELSE '' END \
             FROM pg_class c, aclexplode(c.relacl) a LEFT JOIN pg_roles r ON r.oid = a.grantee \
             WHERE c.oid = '{name}'::regclass AND a.grantee <> c.relowner"
        ));
        let rights: Vec<String> =
            patiently(sqlx::query_scalar(rights).fetch_all(&mut self.connection)).await?;
        let all = [format!("DROP VIEW {name}"), view.to_owned(), comment].into_iter().chain(rights);
        self.at_once(&all.collect::<Vec<_>>().join("; ")).await
    }

    /// Statements in one transaction, after whose failure the session goes on.
    async fn at_once(&mut self, sql: &str) -> Result<(), Trouble> {
        match self.run(format!("BEGIN; {sql}; COMMIT")).await {
            Err(Trouble::Sql(error)) if is_answer(&error) => {
                self.run("ROLLBACK".to_owned()).await?;
                Err(Trouble::Sql(error))
            }
            done => done,
        }
    }
}
