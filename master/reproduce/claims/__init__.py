"""The paper's claims, each with its bound and its verdict."""
